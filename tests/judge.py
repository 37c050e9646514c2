#!/usr/bin/env python3
"""An independent evaluator's word on one result.

    judge.py QUADEVAL NAME INPUT.obj QUADS.obj REPORT.json
"""
import json
import pathlib
import subprocess
import sys

# Has numpy and scipy once `tests/run quadeval` has run.
TOOLS = pathlib.Path(__file__).resolve().parent.parent / "target/tools/python/bin/python"

# Interior irregular vertices that these surfaces must get; the cube's are its corners.
IRREGULAR = {"sphere": 8, "torus": 0, "cube": 8, "rounded_box": 8}


def evaluate(evaluator, kind, *files, options=()):
    """The evaluator's findings as a dict, or None with a reason."""
    python = TOOLS if TOOLS.exists() else sys.executable
    command = [python, evaluator, kind, *files, "--json", *options]
    run = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if run.returncode != 0:
        return None, (run.stderr.strip().splitlines() or ["no reason given"])[-1]
    return json.loads(run.stdout), ""


def verdicts(found, report):
    """Whether the quads are pure, manifold, and of the topology of the input as the report says it was conditioned."""
    counts, shape, defects = found["counts"], found["topology"], found["defects"]
    said = report["input"]
    same = (shape["components"], shape["boundary_loops"], shape["genus"]) == (
        said["components"], said["boundaries"], said["genus"])
    # An input that was repaired has no topology to compare with but that of the repaired surface.
    preserved = found["topology"]["topology_preserved"] is not False or bool(said["repairs"])
    return {
        "pure": counts["pure_quad"] and not defects["repeated_vertex_faces"] and not counts["unreferenced"],
        "manifold": shape["edge_manifold"] and shape["vertex_manifold"] and shape["consistently_oriented"],
        "topology": same and preserved,
    }


def main():
    evaluator, name, mesh, quads, report = sys.argv[1:6]
    found, why = evaluate(evaluator, "mesh", mesh, quads)
    if found is None:
        print(f"{name}: the evaluator cannot read the result: {why}")
        return 1
    with open(report, encoding="utf-8") as file:
        said = json.load(file)
    irregular = said["quads"]["irregular_interior"]
    print(f"{name}: {said['quads']['count']} quads, level {said['level']}, {irregular} irregular inside")
    wrong = [] if said["certified"] else ["not certified"]
    wrong += [f"the evaluator says: not {key}" for key, good in verdicts(found, said).items() if not good]
    if found["valence"]["irregular_interior"] != irregular:
        wrong.append(f"the evaluator counts {found['valence']['irregular_interior']} irregular interior vertices")
    if IRREGULAR.get(name, irregular) != irregular:
        wrong.append(f"{IRREGULAR[name]} irregular interior vertices were expected")
    for what in wrong:
        print(f"  {name}: {what}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
