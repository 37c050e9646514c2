# Sourced by the scripts beside it: a server of one's own on a free loopback port, and its end.
#
# start_server BINARY [SETTING …]: sets `base` (the address), `work` (a folder that goes with the server) and `server`
# (its process); settings are QUADRILLE_… variables.

start_server() {
    local binary=$1
    shift
    work=$(mktemp -d)
    trap stop_server EXIT
    env QUADRILLE_LISTEN=127.0.0.1:0 QUADRILLE_DATA="$work/data" QUADRILLE_LOG__FORMAT=text NO_COLOR=1 "$@" \
        "$binary" serve >"$work/log" 2>&1 &
    server=$!
    local waited
    for waited in $(seq 150); do
        base=$(sed -nE 's/.*listening.*address=([0-9.]+:[0-9]+).*/http:\/\/\1/p' "$work/log" | head -1)
        [ -n "$base" ] && return
        kill -0 "$server" 2>/dev/null || break
        sleep 0.1
    done
    echo "the server does not start:"
    cat "$work/log"
    return 1
}

stop_server() {
    if kill "$server" 2>/dev/null; then
        wait "$server" 2>/dev/null
    fi
    rm -rf "$work"
}

# apt_install PACKAGE …: quietly, as root or by sudo; false when neither is possible.
apt_install() {
    local sudo=()
    [ "$(id -u)" = 0 ] || sudo=(sudo -n)
    export DEBIAN_FRONTEND=noninteractive
    "${sudo[@]}" apt-get install -y -q --no-install-recommends "$@" >/dev/null 2>&1 && return
    "${sudo[@]}" apt-get update -q >/dev/null 2>&1
    "${sudo[@]}" apt-get install -y -q --no-install-recommends "$@" >/dev/null || { echo "cannot install $*"; return 1; }
}

# python_tool NAME PACKAGE==VERSION: the package in a virtual environment of its own, target/tools/NAME.
python_tool() {
    local folder=target/tools/$1
    [ "$(cat "$folder/installed" 2>/dev/null)" = "$2" ] && return
    python3 -c 'import venv, ensurepip' 2>/dev/null || apt_install python3 python3-venv || return 1
    rm -rf "$folder"
    python3 -m venv "$folder" && "$folder/bin/pip" install -q --disable-pip-version-check "$2" || return 1
    echo "$2" >"$folder/installed"
}
