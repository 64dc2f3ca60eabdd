# shellcheck shell=bash
# Checks of the sources by clang and its tools; tests/run sources this:
#   check_format              clang-format on all files
#   lint GROUPS [REV]         the same, and clang-tidy on changed files
#   compile_each_alone GROUPS clang on all files
# GROUPS are the package groups that a complete build needs.

# Source files of the project: tracked by git, or untracked and not ignored.
own_files() {
    git -C "$project" ls-files --cached --others --exclude-standard -- '*.h' '*.cpp' |
        while read -r file; do [[ ! -e $project/$file ]] || printf '%s\n' "$file"; done
}

# The .cpp files that differ from the merge base of REV and HEAD, and for each changed header one
# file that includes it; all files if REV is "all", HEAD itself or unknown to git.
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
                # grep fails for a header that no file includes, and where head ends first.
                *.h) (cd "$project" && own_files | grep '\.cpp$' | xargs grep -lF "\"$file\"" | head -n 1) || true ;;
            esac
        done
}

# The translation units of the lint build that contain one of the files named on standard input.
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

# A unit that passed clang-tidy before is skipped if text and checks are the same. clang-tidy treats
# a unit of several files as one main file, so the analyser also has to check included files. The
# analyser runs only on production code, as it is slow, and so does the check of uninitialised
# members, which reports GoogleTest's copies of our types.
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
        die "formatting differs from clang-format; run clang-format -i FILE"
}

lint() {
    local -r groups=$1
    local revision=${2-}
    [[ -n $revision ]] || revision=$(git -C "$project" rev-parse --verify --quiet origin/main ||
        git -C "$project" rev-parse --verify --quiet main || echo all)
    prepare lint precompiled "$groups lint" --lint "${@:2}"
    cd "$project" || return
    check_format
    local -a units
    mapfile -t units < <(changed_sources "$revision" | units_with)
    say "clang-tidy over ${#units[@]} groups of files"
    ((${#units[@]} > 0)) || return 0
    export -f tidy
    export build project
    # shellcheck disable=SC2016 # expanded by the inner shell
    printf '%s\n' "${units[@]}" | xargs -P "$(nproc)" -n 1 bash -c 'tidy "$0"' ||
        die "tests/run --lint: clang-tidy reported problems"
}

# Compiles each file alone, without precompiled headers.
compile_each_alone() {
    prepare clang precompiled "$1 lint" --clang "${@:2}"
    cd "$build" || return
    grep -o '"command": ".*"' compile_commands.json | grep -v no_source.cpp |
        sed -E 's/^"command": "//; s/"$//; s/\\(["\\])/\1/g; s/ -o [^ ]+ -c / -fsyntax-only /' |
        sed -E 's/^[^ ]*cmake -E env [^ ]+ [^ ]+ //' |
        xargs -d '\n' -P "$(nproc)" -n 1 bash -c
}
