# springdrive doctor with a board on a USB, in tests/usb/virtual_machine: each obstacle is put in
# its way, named, and removed by the line that it prints.
set -e
mkdir -p assets/devices
cp phantom_1_0.toml assets/devices/
export SPRINGDRIVE_ASSETS="$PWD/assets"

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

look
expect 'FAILURE  board on USB: none is connected'
./springdrive device emulate --clock frame >emulator.txt &
until ./springdrive device list | grep -q usb:emulated; do sleep 0.1; done
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
kill %1
