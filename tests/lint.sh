# shellcheck shell=bash
# What clang and its tools say of the sources, for tests/run to source:
#   check_format              clang-format over all
#   lint GROUPS [REV]         that, and clang-tidy over what changed
#   compile_each_alone GROUPS clang over all
# GROUPS are the packages that a whole build needs.

# Files of our own that git knows, or would if they were added.
own_files() {
    git -C "$project" ls-files --cached --others --exclude-standard -- '*.h' '*.cpp' |
        while read -r file; do [[ ! -e $project/$file ]] || printf '%s\n' "$file"; done
}

# The .cpp files in which something differs from where REV and HEAD went apart, and for each changed
# header one that includes it; all where REV is "all", HEAD itself or nothing that git knows.
changed_sources() {
    local since file
    if [[ $1 == all ]] || ! since=$(git -C "$project" merge-base "$1" HEAD 2>/dev/null) ||
        [[ $since == $(git -C "$project" rev-parse HEAD) ]]; then
        own_files | grep '\.cpp$'
        return
    fi
    own_files | grep -Fx -f <(git -C "$project" diff --name-only "$since") |
        while read -r file; do
            case $file in
                *.cpp) printf '%s\n' "$file" ;;
                *.h) (cd "$project" && own_files | grep '\.cpp$' | xargs grep -lF "\"$file\"" | head -n 1) ;;
            esac
        done
}

# The files that the lint build would compile and that hold one of those named on standard input.
units_with() {
    local unit sources
    sources=$(sed "s|.*|\"$project/&\"|")
    grep -o '"file": ".*"' "$build/compile_commands.json" | cut -d '"' -f 4 | grep -v no_source |
        while read -r unit; do
            if grep -qFf <(printf '%s\n' "$sources") <(printf '"%s"\n' "$unit"; grep '^#include' "$unit"); then
                printf '%s\n' "$unit"
            fi
        done
}

# What clang-tidy found nothing in it is not asked about again: same text, same checks. A group of
# files is one main file to it, so the analyser is told to look at what that includes, too; it is kept
# to what ships, for the time it takes, as is the check of members without a value, which GoogleTest's
# copies of our own values set off.
tidy() {
    local -r unit=$1
    local command text mark
    local checks=-bugprone-suspicious-include
    [[ $unit != */tests/* ]] || checks+=',-clang-analyzer-*,-cppcoreguidelines-pro-type-member-init'
    command=$(grep -B 1 -F "\"file\": \"$unit\"" "$build/compile_commands.json" |
        sed -nE 's/^ *"command": "(.*)",$/\1/p' |
        sed -E 's/\\(["\\])/\1/g; s/ -o [^ ]+ -c / -E -P -CC /; s/^[^ ]*cmake -E env [^ ]+ [^ ]+ //')
    text=$({
        echo "$checks"
        clang-tidy --version
        cat "$project/.clang-tidy"
        cd "$build" && eval "$command"
    } | sha256sum)
    mark=${XDG_CACHE_HOME:-$HOME/.cache}/springdrive/tidy/${text%% *}
    [[ ! -e $mark ]] || return 0
    clang-tidy --quiet -p "$build" --warnings-as-errors='*' --checks="$checks" \
        --extra-arg=-Xclang --extra-arg=-analyzer-opt-analyze-headers "$unit" 2>/dev/null ||
        return 1
    mkdir -p "${mark%/*}" && touch "$mark"
}

check_format() {
    (cd "$project" && own_files | xargs clang-format --dry-run --Werror) ||
        die "not as clang-format would have it; clang-format -i FILE mends it"
}

lint() {
    local -r groups=$1
    local revision=${2-}
    [[ -n $revision ]] || revision=$(git -C "$project" rev-parse --verify --quiet origin/main ||
        git -C "$project" rev-parse --verify --quiet main || echo all)
    prepare lint generated/app/view/embedded_shaders.h "$groups lint" --lint "${@:2}"
    cd "$project" || return
    check_format
    local -a units
    mapfile -t units < <(changed_sources "$revision" | units_with)
    say "clang-tidy over ${#units[@]} groups of files"
    ((${#units[@]} > 0)) || return 0
    export -f tidy
    export build project
    # shellcheck disable=SC2016 # for that shell to expand
    printf '%s\n' "${units[@]}" | xargs -P "$(nproc)" -n 1 bash -c 'tidy "$0"' ||
        die "tests/run --lint: clang-tidy found something"
}

# Each file without the others' and without precompiled headers.
compile_each_alone() {
    prepare clang generated/app/view/embedded_shaders.h "$1 lint" --clang "${@:2}"
    cd "$build" || return
    grep -o '"command": ".*"' compile_commands.json | grep -v no_source.cpp |
        sed -E 's/^"command": "//; s/"$//; s/\\(["\\])/\1/g; s/ -o [^ ]+ -c / -fsyntax-only /' |
        sed -E 's/^[^ ]*cmake -E env [^ ]+ [^ ]+ //' |
        xargs -d '\n' -P "$(nproc)" -n 1 bash -c
}
