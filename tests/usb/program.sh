# The whole program on both ends of a USB, in tests/usb/virtual_machine: sh program.sh FUNCTION, one of
# record, doctor and calibrate.
set -e
mkdir -p assets/devices
cp phantom_1_0.toml assets/devices/
export SPRINGDRIVE_ASSETS="$PWD/assets"

# emulate [OPTION...]: plugs an emulated board in.
emulate() {
    ./springdrive device emulate --clock frame "$@" >emulator.txt &
    emulator=$!
    until ./springdrive device list | grep -q usb:; do sleep 0.1; done
}
end_emulator() {
    kill "$emulator"
    wait "$emulator" || true
}

emulate_a_tour() { emulate --loop-hz 20000 --tour 10 --device-seed 7 "$@"; }
self_test() {
    ./springdrive device self-test --device usb --at-zero --motion-seconds 16 \
        --device-file phantom_1_0.toml
}

# A recorded session presses on a plate. The record must be whole, replayed to the last bit, and hold
# half a second of touch at the least. Then a self-test: of a healthy device, and of one that loses
# counts. At last a sweep of the rendered stiffness, which is to be within 2 % and 2 degrees of the
# prediction with the measured d, up to a tenth of the servo rate.
record() {
    printf 't,x,y,z\n0,0,0,0\n1,0,0,0\n2,0,0.03,0\n4,0,-0.01,0\n' >hand.csv
    emulate --path hand.csv
    ./springdrive record touch.rec --device usb --at-zero --lockstep --seconds 4 --scene plate.gltf \
        --device-file phantom_1_0.toml
    ./springdrive replay touch.rec
    ./springdrive export touch.rec --csv touch.csv
    awk -F, '
        NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i; next }
        $column["touching"] == 1 && $column["safety_state"] == 2 { touched++ }
        { e = $column["supply_V"]; if (e != 15) wrong++ }
        END {
            print touched " ticks of touch with full gains; " wrong + 0 " without the supply of the board"
            exit !(touched >= 500 && wrong == 0)
        }' touch.csv
    end_emulator

    emulate_a_tour
    ./springdrive device info --device usb
    self_test
    end_emulator
    emulate_a_tour --fault lost-counts:2:0.1
    if self_test >damaged.txt; then exit 1; fi
    grep 'encoder 2 counts' damaged.txt
    end_emulator

    emulate
    # As the emulated motors are: else dR is held up until a touch has told R from V_b.
    sed '/greatest_brush_voltage_V/s/0\.5/0.0/' phantom_1_0.toml >brushless.toml
    ./springdrive device sweep --device usb --at-zero --motors 2 --freq-from 2 --points 4 --tolerance 2 \
        --device-file brushless.toml
    end_emulator
}

# look [COMMAND...]: what the doctor says, run by the command.
look() {
    "$@" ./springdrive doctor --device usb --no-window >said.txt 2>&1 || true
}

# expect TEXT...: what it said contains each.
expect() {
    for text in "$@"; do
        if ! grep -qF "$text" said.txt; then
            echo "not found: $text, in:"
            cat said.txt
            exit 1
        fi
        echo "found: $text"
    done
}

# mend TITLE: runs the line that it gave for the check.
mend() {
    line=$(grep -A2 -F "$1" said.txt | sed -n 's/^ *do:  //p' | head -n 1)
    echo "mending by: $line"
    sh -c "$line"
}

# Each obstacle is put in the doctor's way, named, and removed by the line that it prints.
doctor() {
    look
    expect 'FAILURE  board on USB: none is connected'
    emulate
    node=$(ls /dev/bus/usb/001/* | tail -n 1)

    # Not busybox' own setpriv, which knows no users.
    look ./setpriv --reuid=65534 --regid=65534 --clear-groups
    expect "FAILURE  permission for the board at 1-1: $node may not be written to" \
        '70-springdrive-usb.rules && sudo udevadm control --reload'
    chown 65534 "$node"
    look ./setpriv --reuid=65534 --regid=65534 --clear-groups
    expect "ok       permission for board emulated: $node may be used"

    rm "$node"
    echo auto >/sys/bus/usb/devices/1-1/power/control
    look
    expect "$node is missing, though the kernel has the board at 1-1" \
        'warning  autosuspend of the board at 1-1: control is auto: suspended after '
    mend 'permission for'
    mend 'autosuspend of'
    look
    expect 'ok       board on USB: board emulated' \
        "ok       permission for board emulated: $node may be used" \
        'ok       firmware of board emulated: springdrive emulator ' \
        'ok       speed of board emulated: 480 Mbit/s' \
        'ok       autosuspend of board emulated: control is on' \
        'is a port of the computer'

    # While a session has it, and after.
    ./springdrive record touch.rec --device usb --at-zero --lockstep --seconds 3 --scene plate.gltf \
        --device-file phantom_1_0.toml >session.txt 2>&1 &
    session=$!
    until [ -s touch.rec ]; do sleep 0.05; done
    look
    expect "$node is used by springdrive, process $session"
    wait $session || { cat session.txt; exit 1; }
    look
    expect "$node may be used"
    end_emulator
}

# A drawn device is calibrated while the emulator's hand moves it about, and keeps it on its board and
# in a file. The board gives it to whoever asks, and the file is refused for another device.
calibrate() {
    # Rests in the zero pose, then goes to and fro about the middle of the workspace, in no two
    # directions in step.
    awk 'function to_and_fro(x) { x -= int(x); return x < 0.5 ? 4 * x - 1 : 3 - 4 * x }
    BEGIN {
        print "t,x,y,z\n0,0,0,0"
        for (i = 1; i <= 3000; i++) {
            t = i * 0.02
            share = t < 4 ? 0 : t < 6 ? (t - 4) / 2 : 1
            printf "%.2f,%.6f,%.6f,%.6f\n", t, share * 0.056 * to_and_fro(t / 2.6),
                share * (0.030 + 0.039 * to_and_fro(t / 3.1)),
                share * (-0.015 + 0.028 * to_and_fro(t / 3.7))
        }
    }' >tour.csv

    emulate --loop-hz 20000 --device-seed 7 --path tour.csv
    ./springdrive device calibrate --device usb --at-zero --device-file phantom_1_0.toml --to-board \
        --out calibrated.toml --motion-seconds 50 >calibration.txt || {
        cat calibration.txt
        exit 1
    }
    cat calibration.txt
    grep 'stored on the board' calibration.txt
    grep -A 5 '^\[calibration' calibrated.toml
    ./springdrive device info --device usb | tee information.txt
    grep '^calibration' information.txt
    if grep '^calibration  *none' information.txt; then exit 1; fi
    end_emulator

    emulate --loop-hz 20000 --device-seed 7 --serial another
    if ./springdrive record refused.rec --device usb --at-zero --lockstep --seconds 1 --scene plate.gltf \
        --device-file calibrated.toml 2>refused.txt; then
        echo 'the calibration of another device was not refused'
        exit 1
    fi
    cat refused.txt
    grep 'another' refused.txt
    end_emulator
}

"$1"
