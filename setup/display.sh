# shellcheck shell=bash
# A virtual display for machines without one; app/run and tests/run source this after prepare.sh.

has_display() { [[ -n ${DISPLAY-} || -n ${WAYLAND_DISPLAY-} ]]; }

# Sets DISPLAY to an Xvfb that ends whenever this process ends, and that survives an `exec`. The
# program can therefore replace the shell: signals reach it directly, without xvfb-run in between.
start_virtual_display() {
    command -v Xvfb >/dev/null || die "no display, and Xvfb is not installed"
    # shellcheck disable=SC2154 # set by prepare.sh
    local -r log=$project/build/xvfb.log
    local server number
    # --pdeathsig: SIGTERM once this process is gone.
    # setsid: Ctrl-C must reach only the program, which needs its display for an orderly shutdown.
    # -noreset: the display persists when one program disconnects before the next one connects.
    exec {server}< <(
        exec setpriv --pdeathsig TERM setsid \
            Xvfb -displayfd 3 -screen 0 1280x800x24 +extension GLX -noreset 3>&1 >"$log" 2>&1
    )
    read -r -t 30 number <&"$server" || die "Xvfb did not start; see $log"
    exec {server}<&-
    export DISPLAY=:$number
}
