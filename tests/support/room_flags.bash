# Compiler flags, for checks of what compiles and what does not.

# flags_of BUILD_FOLDER ROOM prints the command that compiled a file of the room, without its input,
# output and precompiled headers.
flags_of() {
    awk -v target="[ /]CMakeFiles/$2[.]dir/" '
        /^ *"command": / && $0 ~ target {
            sub(/^ *"command": "/, "")
            sub(/",$/, "")
            print
            exit
        }' "$1/compile_commands.json" |
        sed -E 's/\\(["\\])/\1/g; s/ -o [^ ]+ -c [^ ]+$//; s/^[^ ]*cmake -E env [^ ]+ [^ ]+ //' |
        sed -E 's/^[^ ]*ccache //; s/ -Winvalid-pch//; s/ -include [^ ]+//'
}
