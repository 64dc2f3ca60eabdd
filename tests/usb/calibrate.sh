# springdrive device calibrate over a USB, in tests/usb/virtual_machine: a drawn device is calibrated
# while the emulator's hand moves it about, and keeps it on its board and in a file. The board gives it
# to whoever asks, and the file is refused for another device.
set -e
mkdir -p assets/devices
cp phantom_1_0.toml assets/devices/
export SPRINGDRIVE_ASSETS="$PWD/assets"
emulate() {
    ./springdrive device emulate --clock frame --loop-hz 20000 --device-seed 7 "$@" >emulator.txt &
    emulator=$!
    until ./springdrive device list | grep -q usb:; do sleep 0.1; done
}
end_emulator() {
    kill "$emulator"
    wait "$emulator" || true
}
# Rests in the zero pose, then goes to and fro about the middle of the workspace, in no two directions
# in step.
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

emulate --path tour.csv
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

emulate --serial another
if ./springdrive record refused.rec --device usb --at-zero --lockstep --seconds 1 --scene plate.gltf \
    --device-file calibrated.toml 2>refused.txt; then
    echo 'the calibration of another device was not refused'
    exit 1
fi
cat refused.txt
grep 'another' refused.txt
end_emulator
