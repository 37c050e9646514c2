//! Comparing transforms that went through single precision.

use glam::DMat4;
use glam::DVec4;

/// Relative difference of matrices that are the same but for rounding on their way through files.
const ROUNDING: f64 = 1e-5;
/// Numbers in matrices beyond this, or below its inverse, come from nowhere.
const LARGEST: f64 = 1e12;

/// `world · bind`, the transform that puts vertices into the scene. The identity where that is it but for rounding, so that
/// positions keep all their digits, and where it cannot be inverted.
pub(super) fn placement(world: &DMat4, bind: &DMat4) -> DMat4 {
    let made = world * bind;
    let size = absolute(world) * absolute(bind);
    let is_identity = differ_less(&made, &DMat4::IDENTITY, &size);
    if is_identity || !is_usable(&made) { DMat4::IDENTITY } else { made }
}

/// Whether a transform can be inverted with any digits left.
pub(super) fn is_usable(transform: &DMat4) -> bool {
    let is_sane = |m: &DMat4| m.to_cols_array().iter().all(|x| x.abs() < LARGEST);
    transform.determinant() != 0.0 && is_sane(transform) && is_sane(&transform.inverse())
}

/// Whether two affine transforms are the same but for rounding.
pub(super) fn alike(a: &DMat4, b: &DMat4) -> bool {
    differ_less(a, b, &(absolute(a) + absolute(b)))
}

/// By columns in single precision, the last row 0 0 0 1; `None` if a number is none.
pub(super) fn by_columns(transform: &DMat4) -> Option<[f32; 16]> {
    let mut columns = transform.to_cols_array().map(|x| x as f32);
    for (k, x) in [(3, 0.0), (7, 0.0), (11, 0.0), (15, 1.0)] {
        columns[k] = x;
    }
    columns.iter().all(|x| x.is_finite()).then_some(columns)
}

/// Whether matrices whose numbers are sums of such sizes are the same; the linear part and the translation are measured
/// each as a whole.
fn differ_less(a: &DMat4, b: &DMat4, size: &DMat4) -> bool {
    let largest = |columns: &[DVec4]| columns.iter().map(|c| c.truncate().max_element()).fold(0.0, f64::max);
    let difference = absolute(&(*a - *b));
    let linear = largest(&[difference.x_axis, difference.y_axis, difference.z_axis]);
    let moved = largest(&[difference.w_axis]);
    let linear_size = largest(&[size.x_axis, size.y_axis, size.z_axis]);
    linear <= ROUNDING * linear_size && moved <= ROUNDING * largest(&[size.w_axis])
}

fn absolute(matrix: &DMat4) -> DMat4 {
    DMat4::from_cols(matrix.x_axis.abs(), matrix.y_axis.abs(), matrix.z_axis.abs(), matrix.w_axis.abs())
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use glam::DVec3;

    use super::*;

    #[test]
    fn rounded_inverses_are_the_identity_and_others_are_not() {
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, std::f64::consts::FRAC_PI_2, -1.0);
        let world = DMat4::from_scale_rotation_translation(DVec3::splat(0.01), turn, DVec3::new(3.0, -200.0, 1e-3));
        let bind = world.inverse();
        let rounded = DMat4::from_cols_array(&by_columns(&bind).unwrap().map(f64::from));
        assert!(rounded != bind && alike(&rounded, &bind));
        assert_eq!(placement(&world, &rounded), DMat4::IDENTITY);
        let moved = DMat4::from_translation(DVec3::X);
        assert_eq!(placement(&moved, &DMat4::IDENTITY), moved);
        assert!(!alike(&moved, &DMat4::IDENTITY));
    }

    #[test]
    fn nonsense_places_nothing() {
        for bad in [DMat4::ZERO, DMat4::from_scale(DVec3::splat(1e-20)), DMat4::from_scale(DVec3::NAN)] {
            assert_eq!(placement(&bad, &DMat4::IDENTITY), DMat4::IDENTITY);
        }
        assert_eq!(by_columns(&DMat4::from_scale(DVec3::splat(1e300))), None);
    }
}
