#!/bin/sh
# Prepares a machine to build and run Surelight. Safe to run again at any time: it looks first, installs only what is
# missing, and says what it did.
#
#   Linux      a Vulkan loader and, where no usable Vulkan driver is found, Mesa's software driver lavapipe
#   macOS      nothing: Metal comes with the system
#   Windows    nothing: Direct3D 12 comes with the system
#
# Rust and a linker are only looked for, never installed: how they are managed is the user's business.
set -eu

say() { printf 'setup: %s\n' "$*"; }
die() { printf 'setup: error: %s\n' "$*" >&2; exit 1; }

# --- What is there -----------------------------------------------------------------------------------------------------

# The libraries that the dynamic linker knows, one a line. Debian keeps ldconfig out of a plain user's PATH.
known_libraries() {
    for tool in ldconfig /sbin/ldconfig /usr/sbin/ldconfig; do
        if command -v "$tool" >/dev/null 2>&1; then "$tool" -p 2>/dev/null && return 0; fi
    done
    ls /usr/lib /usr/lib64 /usr/local/lib /lib 2>/dev/null || true   # musl has no cache to ask
}

# has_library NAME: whether the dynamic linker would find it.
has_library() {
    case "$libraries" in *"$1"*) return 0 ;; esac
    old_ifs=$IFS; IFS=:
    for folder in ${LD_LIBRARY_PATH:-}; do
        if [ -e "$folder/$1" ]; then IFS=$old_ifs; return 0; fi
    done
    IFS=$old_ifs
    return 1
}

# Driver manifests (ICD files), one a line, in the places where the Vulkan loader looks.
manifests() {
    override=${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}
    if [ -n "$override" ]; then
        places=$override
    else
        places=${VK_ADD_DRIVER_FILES:-}
        for base in "${XDG_CONFIG_HOME:-${HOME:-/root}/.config}" /etc/xdg /usr/local/etc /etc \
            "${XDG_DATA_HOME:-${HOME:-/root}/.local/share}" /usr/local/share /usr/share /run/opengl-driver/share; do
            places=$places:$base/vulkan/icd.d
        done
    fi
    old_ifs=$IFS; IFS=:
    for place in $places; do
        IFS=$old_ifs
        if [ -d "$place" ]; then
            for file in "$place"/*.json; do if [ -r "$file" ]; then printf '%s\n' "$file"; fi; done
        elif [ -n "$place" ] && [ -r "$place" ]; then
            printf '%s\n' "$place"
        fi
        IFS=:
    done
    IFS=$old_ifs
}

# Whether this user can open a GPU. A driver without its device is no use, and packages bring many at once.
has_gpu() {
    for node in /dev/dri/renderD* /dev/nvidia0 /dev/nvidiactl /dev/dxg /dev/mali0 /dev/kgsl-3d0; do
        if [ -r "$node" ] && [ -w "$node" ]; then return 0; fi
    done
    return 1
}

# usable MANIFEST: whether its driver's library is there, and its device too unless it renders on the CPU.
usable() {
    library=$(sed -n 's/.*"library_path"[[:space:]]*:[[:space:]]*"\([^"]*\)".*/\1/p' "$1" | head -n 1)
    case "$library" in
        '') return 1 ;;
        /*) [ -e "$library" ] || return 1 ;;
        */*) [ -e "$(dirname "$1")/$library" ] || return 1 ;;
        *) has_library "$library" || return 1 ;;
    esac
    case "$library" in
        *libvulkan_lvp* | *swiftshader*) return 0 ;;
        *) has_gpu ;;
    esac
}

# Prints the manifest of the first usable driver.
find_driver() {
    manifests | while IFS= read -r file; do
        if usable "$file"; then printf '%s\n' "$file"; break; fi
    done
}

# Fills `loader` (yes or no) and `driver` (a manifest, or nothing).
look() {
    libraries=$(known_libraries)
    if has_library libvulkan.so.1; then loader=yes; else loader=no; fi
    driver=$(find_driver)
}

# --- What to do about it -----------------------------------------------------------------------------------------------

as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    elif command -v sudo >/dev/null 2>&1; then
        sudo "$@"
    elif command -v doas >/dev/null 2>&1; then
        doas "$@"
    else
        die "this needs root and neither sudo nor doas is here; run as root: $*"
    fi
}

install_vulkan() {
    if command -v apt-get >/dev/null 2>&1; then
        say "installing libvulkan1 and mesa-vulkan-drivers with apt-get"
        as_root apt-get update -qq || say "apt-get update failed; trying with the package lists at hand"
        as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
            libvulkan1 mesa-vulkan-drivers
    elif command -v dnf >/dev/null 2>&1; then
        say "installing vulkan-loader and mesa-vulkan-drivers with dnf"
        as_root dnf install -y -q vulkan-loader mesa-vulkan-drivers
    elif command -v pacman >/dev/null 2>&1; then
        say "installing vulkan-icd-loader and vulkan-swrast with pacman"
        as_root pacman -S --needed --noconfirm vulkan-icd-loader vulkan-swrast ||
            as_root pacman -Sy --needed --noconfirm vulkan-icd-loader vulkan-swrast   # a fresh image has no package lists
    else
        die "no apt-get, dnf or pacman here: install a Vulkan loader (libvulkan.so.1) and a driver (Mesa's lavapipe runs on any CPU) with your package manager"
    fi
}

check_vulkan() {
    look
    if [ "$loader" = yes ] && [ -n "$driver" ]; then
        say "nothing to install: Vulkan loader found, driver $driver"
        return
    fi
    if [ -n "${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}" ] && [ -z "$driver" ]; then
        die "VK_DRIVER_FILES or VK_ICD_FILENAMES names no usable driver (${VK_DRIVER_FILES:-$VK_ICD_FILENAMES}): unset it, or point it at a driver's .json file"
    fi
    if [ "$loader" = no ]; then say "no Vulkan loader (libvulkan.so.1) found"; fi
    if [ -z "$driver" ]; then say "no usable Vulkan driver found"; fi
    install_vulkan || die "the packages could not be installed (see above)"
    look
    if [ "$loader" = no ] || [ -z "$driver" ]; then
        die "the packages are installed, but no Vulkan loader or driver turned up; is this an unusual system?"
    fi
    say "installed: Vulkan loader and driver $driver"
}

# Rust of at least the version that Cargo.toml asks for, and a linker for it.
check_rust() {
    wanted=$(sed -n 's/^rust-version *= *"\([^"]*\)".*/\1/p' "$(dirname "$0")/Cargo.toml" | head -n 1)
    if ! command -v cargo >/dev/null 2>&1; then
        if [ -x "${CARGO_HOME:-${HOME:-/root}/.cargo}/bin/cargo" ]; then
            die "Rust is installed but not in PATH; run: . \"${CARGO_HOME:-$HOME/.cargo}/env\""
        fi
        die "Rust $wanted or later is needed; get it from https://rustup.rs (or your package manager), then run this again"
    fi
    have=$(rustc --version 2>/dev/null | sed -n 's/^rustc \([0-9]*\.[0-9]*\).*/\1/p')
    if [ -z "$have" ]; then die "rustc does not run; with rustup, this repairs it: rustup default stable"; fi
    if [ "${have%%.*}" -lt "${wanted%%.*}" ] ||
        { [ "${have%%.*}" -eq "${wanted%%.*}" ] && [ "${have#*.}" -lt "${wanted#*.}" ]; }; then
        die "Rust $wanted or later is needed and this is $have; with rustup: rustup update stable"
    fi
    if [ "$system" = Linux ] && ! command -v cc >/dev/null 2>&1; then
        die "Rust needs a linker: install gcc or clang (Debian and Ubuntu: build-essential; Fedora: gcc; Arch: base-devel)"
    fi
}

system=$(uname -s)
case "$system" in
    Linux) check_vulkan ;;
    Darwin) say "nothing to install: macOS brings Metal" ;;
    MINGW* | MSYS* | CYGWIN*) say "nothing to install: Windows brings Direct3D 12" ;;
    *) say "$system is not a system Surelight knows; it needs a Vulkan loader and driver" ;;
esac
check_rust
