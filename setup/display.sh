# shellcheck shell=bash
# A virtual display where there is none, for app/run and tests/run to source after prepare.sh.

has_display() { [[ -n ${DISPLAY-} || -n ${WAYLAND_DISPLAY-} ]]; }

# Sets DISPLAY to an Xvfb that ends with this process, however it ends, and outlasts an `exec`.
# So the program can take the shell's place: signals reach it with no xvfb-run between to lose them.
start_virtual_display() {
    command -v Xvfb >/dev/null || die "no display, and no Xvfb to stand in for one"
    # shellcheck disable=SC2154 # set by prepare.sh
    local -r log=$project/build/xvfb.log
    local server number
    # --pdeathsig: SIGTERM once this process is gone.
    # setsid: Ctrl-C is for the program, which still needs its display to end in good order.
    # -noreset: the display is not interrupted when one program leaves before the next one comes.
    exec {server}< <(
        exec setpriv --pdeathsig TERM setsid \
            Xvfb -displayfd 3 -screen 0 1280x800x24 +extension GLX -noreset 3>&1 >"$log" 2>&1
    )
    read -r -t 30 number <&"$server" || die "Xvfb did not start; see $log"
    exec {server}<&-
    export DISPLAY=:$number
}
