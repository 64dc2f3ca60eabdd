# shellcheck shell=bash
# Installs packages, configures and builds; app/run, tests/run and setup/make_package source this:
#   prepare PRESET TARGETS GROUPS ARGUMENT...   installs missing packages of these groups,
#                                               configures the preset, builds the TARGETs
# ARGUMENTs are those of the caller, passed on if it has to be restarted as another user.
# Standard input and output are reserved for the program; messages go to standard error.

project=$(readlink -f "$(dirname "${BASH_SOURCE[0]}")/..")
packages=$project/setup/packages.txt
readonly project packages

prepare() {
    local -r targets=$2 groups=$3
    preset=$1
    build=$project/build/$preset
    shift 3
    install_missing_packages "$groups" </dev/null >&2
    leave_root_of_sudo "$@"
    configure "$groups" </dev/null >&2
    build "$targets" </dev/null >&2
}

say() { printf 'springdrive: %s\n' "$*" >&2; }

die() {
    say "$*"
    exit 1
}

# Debian or a distribution based on it, such as Ubuntu.
is_debian() {
    local -r os_release=${SPRINGDRIVE_OS_RELEASE:-/etc/os-release}
    # shellcheck source=/dev/null
    case " $(. "$os_release" 2>/dev/null && echo "${ID-} ${ID_LIKE-}") " in
        *" debian "* | *" ubuntu "*) ;;
        *) return 1 ;;
    esac
}

# The packages of these groups; of all groups if none is named.
packages_of() {
    awk -v groups=" ${1-} " '
        /^\[/ { taken = groups == "  " || index(groups, " " substr($1, 2, length($1) - 2) " ") }
        /^[a-z]/ && taken { print $1 }' "$packages"
}

# Queries only dpkg, which is fast when nothing is missing.
missing_packages() {
    # shellcheck disable=SC2016 # the variables are dpkg's
    local -r installed='${db:Status-Status} ${Package}\n'
    packages_of "$1" |
        grep -vxFf <(dpkg-query --show --showformat="$installed" | sed -n 's/^installed //p') ||
        true # grep fails if none is missing
}

install_missing_packages() {
    is_debian || return 0
    local -a missing as_root=()
    mapfile -t missing < <(missing_packages "$1")
    ((${#missing[@]} > 0)) || return 0

    local -r install="apt-get install --no-install-recommends ${missing[*]}"
    if ((EUID != 0)); then
        command -v sudo >/dev/null ||
            die "packages are missing, and neither root nor sudo is available to install them;" \
                "as root run: apt-get update && $install"
        as_root=(sudo)
        say "installing packages with sudo, which may ask for your password"
    fi
    say "installing ${#missing[@]} packages: ${missing[*]}"
    as_root+=(env DEBIAN_FRONTEND=noninteractive apt-get --yes -o DPkg::Lock::Timeout=120)
    wait_for_package_lists
    "${as_root[@]}" update || say "apt-get update failed; trying with the existing package lists"
    "${as_root[@]}" install --no-install-recommends "${missing[@]}" ||
        die "could not install the packages; as root try: apt-get update && $install"
}

# Another apt-get may be updating the lists, as on a new machine after its first boot. Our apt-get
# would not wait for it: DPkg::Lock::Timeout applies only to dpkg's lock.
wait_for_package_lists() {
    local inode seconds
    inode=$(stat --format=%i /var/lib/apt/lists/lock 2>/dev/null) || return 0
    for ((seconds = 0; seconds < 120; ++seconds)); do
        grep -q ":$inode " /proc/locks || return 0
        ((seconds > 0)) || say "waiting for another apt-get to finish"
        sleep 1
    done
}

# Under sudo, root only installs packages: building and running is done as the user, unless root
# owns the tree.
leave_root_of_sudo() {
    [[ $EUID == 0 && ${SUDO_UID:-0} != 0 && ! -O $project ]] || return 0
    local home
    home=$(getent passwd "$SUDO_UID" | cut -d: -f6)
    exec setpriv --reuid="$SUDO_UID" --regid="${SUDO_GID:?}" --init-groups \
        env HOME="$home" USER="${SUDO_USER:?}" LOGNAME="$SUDO_USER" \
        bash "$(readlink -f "$0")" "$@"
}

check_other_distribution() {
    local tool
    say "neither Debian nor Ubuntu: packages must be installed by hand. Debian names:"
    packages_of | sed 's/^/  /'
    for tool in cmake ninja c++; do
        command -v "$tool" >/dev/null ||
            die "'$tool' not found; install the packages listed above, then start again"
    done
}

# A tree that was moved is reconfigured, as CMake stores absolute paths.
is_configured() {
    [[ -f $build/build.ninja ]] &&
        grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$project" "$build/CMakeCache.txt"
}

is_on() { grep -qxF "$1:BOOL=ON" "$build/CMakeCache.txt"; }

# Options that were enabled once stay enabled.
configure() {
    local -r groups=$1
    local -a options=(--fresh)
    local option
    if is_configured; then options=(); fi
    for option in charts tests benchmarks; do
        if [[ " $groups " == *" $option "* ]]; then
            is_configured && is_on "SPRINGDRIVE_${option^^}" ||
                options+=(-D "SPRINGDRIVE_${option^^}=ON")
        elif ! is_configured; then
            options+=(-D "SPRINGDRIVE_${option^^}=OFF")
        fi
    done
    ((${#options[@]} > 0)) || return 0
    is_debian || check_other_distribution
    say "configuring build/$preset"
    rm -f "$build/build.ninja"
    cmake -S "$project" --preset "$preset" "${options[@]}" ||
        die "could not configure; setup/packages.txt lists what is needed"
}

build() {
    local -a targets
    read -r -a targets <<<"$1"
    # A dry run first, as ninja cannot be silent only when there is nothing to do.
    [[ $(ninja -C "$build" -n "${targets[@]}") != *"no work to do"* ]] || return 0
    say "building ${targets[*]}"
    # Killing this script must not leave a build behind.
    setpriv --pdeathsig TERM ninja -C "$build" -j "$(job_count)" "${targets[@]}"
}

# As many jobs as cores and available memory allow: a compiler may need 2 GiB.
job_count() {
    awk -v cores="$(nproc)" '/^MemAvailable:/ {
        fit = int($2 / (2 * 1024 * 1024))
        print fit < 1 ? 1 : (fit < cores ? fit : cores)
    }' /proc/meminfo
}
