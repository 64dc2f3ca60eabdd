# The whole program on both ends of a USB, in tests/usb/virtual_machine: the emulator on one, a
# recorded session on the other, which presses on a plate. The record must be whole, replayed to the
# last bit, and hold half a second of touch at the least. Then a self-test: of a healthy device, and of
# one that loses counts. At last a sweep of the rendered stiffness, which is to be within 2 % and 2
# degrees of the prediction with the measured d, up to a tenth of the servo rate.
set -e
mkdir -p assets/devices
cp phantom_1_0.toml assets/devices/
export SPRINGDRIVE_ASSETS="$PWD/assets"
end_emulator() {
    kill "$emulator"
    wait "$emulator" || true
}
printf 't,x,y,z\n0,0,0,0\n1,0,0,0\n2,0,0.03,0\n4,0,-0.01,0\n' >hand.csv
./springdrive device emulate --clock frame --path hand.csv >emulator.txt &
emulator=$!
until ./springdrive device list | grep -q usb:emulated; do sleep 0.1; done
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

emulate_a_tour() {
    ./springdrive device emulate --clock frame --loop-hz 20000 --tour 4 --device-seed 7 "$@" \
        >emulator.txt &
    emulator=$!
    until ./springdrive device list | grep -q usb:emulated; do sleep 0.1; done
}
self_test() {
    ./springdrive device self-test --device usb --at-zero --motion-seconds 14 \
        --device-file phantom_1_0.toml
}
emulate_a_tour
./springdrive device info --device usb
self_test
end_emulator
emulate_a_tour --fault lost-counts:2:0.1
if self_test >damaged.txt; then exit 1; fi
grep 'encoder 2 counts' damaged.txt
end_emulator

./springdrive device emulate --clock frame >emulator.txt &
emulator=$!
until ./springdrive device list | grep -q usb:emulated; do sleep 0.1; done
./springdrive device sweep --device usb --at-zero --motors 2 --freq-from 2 --points 4 --tolerance 2 \
    --device-file phantom_1_0.toml
end_emulator
