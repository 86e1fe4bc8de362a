# shellcheck shell=bash
# Shared by the scripts beside it: `source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"`.
set -euo pipefail

ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck disable=SC2034 # used by the scripts
TARGET=${CARGO_TARGET_DIR:-$ROOT/target}
# Exit status of a script whose product cannot exist on this machine: tests then say "ignored".
UNAVAILABLE=77

say() { echo "$*" >&2; }
die() {
    say "${0##*/}: $*"
    exit 1
}
unavailable() {
    say "${0##*/}: not available: $*"
    exit "$UNAVAILABLE"
}
have() { command -v "$1" >/dev/null; }

# usage: prints the comment at the head of the script.
usage() {
    sed -n '2,/^[^#]/{/^# shellcheck/d;s/^# \{0,1\}//p}' "$0"
    exit 0
}

is_installed() { [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

# ensure_packages PACKAGE...: installs those Debian packages that are missing, or says the exact command and returns 1.
ensure_packages() {
    local missing=() package as_root=()
    have apt-get || {
        say "This machine has no apt-get. Install by hand what Debian calls: $*"
        return 1
    }
    for package in "$@"; do is_installed "$package" || missing+=("$package"); done
    [ ${#missing[@]} -gt 0 ] || return 0
    if [ "$(id -u)" -ne 0 ]; then
        if ! have sudo || ! sudo -n true 2>/dev/null; then
            say "Missing Debian packages. Install them with:"
            say "    sudo apt-get update && sudo apt-get install --no-install-recommends ${missing[*]}"
            return 1
        fi
        as_root=(sudo -n)
    fi
    say "Installing ${missing[*]} ..."
    # Package lists may be absent (containers) or stale: refresh them only when the first attempt fails.
    apt_install "${missing[@]}" 2>/dev/null || {
        "${as_root[@]}" apt-get -qq update >&2 && apt_install "${missing[@]}"
    }
}

# For ensure_packages, whose `as_root` it uses.
apt_install() {
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -y --no-install-recommends install "$@" >&2
}

# ensure_rust: a toolchain and a linker for it.
ensure_rust() {
    have cargo || die "cargo is missing: install a Rust toolchain (rustup, or your distribution's packages) and run again"
    have cc || ensure_packages gcc libc6-dev || exit 1
}

# ensure_vulkan: the loader, and lavapipe (a driver for the CPU) where the machine has no Vulkan driver at all.
ensure_vulkan() {
    local missing=() manifests
    if ! PATH=$PATH:/sbin:/usr/sbin ldconfig -p 2>/dev/null | grep -F libvulkan.so.1 >/dev/null; then
        missing+=(libvulkan1)
    fi
    manifests=$(find /etc/vulkan/icd.d /usr/share/vulkan/icd.d /usr/local/share/vulkan/icd.d \
        "${XDG_DATA_HOME:-$HOME/.local/share}/vulkan/icd.d" -name '*.json' 2>/dev/null || true)
    [ -n "$manifests${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] || missing+=(mesa-vulkan-drivers)
    [ ${#missing[@]} -eq 0 ] || ensure_packages "${missing[@]}" || exit 1
}

# debian_mirrors: the Debian archives that this machine's apt is configured for, best first.
debian_mirrors() {
    # shellcheck disable=SC2016 # apt's own placeholders
    apt-get indextargets --format '$(REPO_URI) $(ORIGIN)' 'Created-By: Packages' |
        awk '!/security/ && ($2 == "Debian" || $1 ~ /\/debian\/?$/) && !seen[$1]++ { print $1 }'
}

# unpack_debian DIR ARCHITECTURE SUITE SKIP PACKAGE...: unpacks the packages and all that they depend on, except names
# that match the regular expression SKIP, below DIR. Installs nothing and keeps its own package lists; apt checks the
# archive's signature and every hash. With SKIP '*', nothing but the packages themselves.
unpack_debian() {
    local dir=$1 architecture=$2 suite=$3 skip=$4 keyring mirror state wanted file apt
    shift 4
    keyring=$(find /usr/share/keyrings -name 'debian-archive-keyring.*' 2>/dev/null | sort | head -n 1)
    [ -n "$keyring" ] || {
        say "Debian's archive keys are missing (package debian-archive-keyring)"
        return 1
    }
    state=$(mktemp -d)
    mkdir -p "$dir" "$state/lists/partial" "$state/cache/archives/partial" "$state/debs"
    : >"$state/status"
    apt=(
        -qq -o "APT::Architecture=$architecture" -o "APT::Architectures=$architecture" -o "APT::Sandbox::User=$(id -un)"
        -o "Dir::State=$state" -o "Dir::State::Lists=$state/lists" -o "Dir::State::status=$state/status"
        -o "Dir::Cache=$state/cache" -o "Dir::Etc::SourceList=$state/sources.list"
        -o "Dir::Etc::SourceParts=/dev/null" -o "Dir::Etc::Preferences=/dev/null" -o "Dir::Etc::PreferencesParts=/dev/null"
        -o "Acquire::Languages=none" -o "Acquire::IndexTargets::deb::DEP-11::DefaultEnabled=false"
        -o "APT::Update::Error-Mode=any" -o "Debug::NoLocking=true"
    )
    for mirror in ${ONTILE_DEBIAN_MIRROR:-$(debian_mirrors)}; do
        echo "deb [signed-by=$keyring] $mirror $suite main" >"$state/sources.list"
        if apt-get "${apt[@]}" update >&2; then
            if [ "$skip" = '*' ]; then
                wanted=$*
            else
                wanted=$(apt-get "${apt[@]}" --simulate --no-install-recommends install "$@" |
                    awk -v skip="^($skip)" '$1 == "Inst" && $2 !~ skip { print $2 }')
            fi
            # shellcheck disable=SC2086 # one word a package
            if [ -n "$wanted" ] && (cd "$state/debs" && apt-get "${apt[@]}" download $wanted >&2); then
                # Merged /usr, as the packages expect it.
                mkdir -p "$dir/usr/bin" "$dir/usr/lib" "$dir/usr/lib64"
                ln -sfn usr/bin "$dir/bin" && ln -sfn usr/lib "$dir/lib" && ln -sfn usr/lib64 "$dir/lib64"
                for file in "$state"/debs/*.deb; do
                    dpkg-deb --fsys-tarfile "$file" | tar -x --keep-directory-symlink --no-same-owner -C "$dir"
                done
                rm -rf "$state"
                return 0
            fi
        fi
        say "$mirror: cannot get these packages of suite $suite"
    done
    rm -rf "$state"
    return 1
}

# require_unpacking_tools: leaves with UNAVAILABLE unless unpack_debian can work here.
require_unpacking_tools() {
    local tool
    for tool in apt-get dpkg dpkg-deb tar; do have "$tool" || unavailable "needs $tool (a Debian-like machine)"; done
    [ -n "${ONTILE_DEBIAN_MIRROR:-$(debian_mirrors)}" ] ||
        unavailable "apt is not configured for a Debian archive; set ONTILE_DEBIAN_MIRROR to the address of one"
}

# relocatable_manifest MANIFEST NEW LIBRARIES: a driver's or layer's manifest that names its library relative to itself, so that
# the folder can be moved and cached.
relocatable_manifest() { sed -E "s#(\"library_path\": *\")[^\"]*/?(lib[^/\"]+\")#\1../$3/\2#" "$1" >"$2"; }

# own_libc_system DIR LIBRARIES ICD PRELOAD WHAT ENVIRONMENT: makes of a system that was unpacked into DIR/root, whose
# libraries are in DIR/LIBRARIES, a wrapper DIR/run that starts programs on the driver with manifest ICD, and the manifests
# that it needs. PRELOAD is a library or empty; WHAT and ENVIRONMENT are a comment and a line of the wrapper.
own_libc_system() {
    local dir=$1 libraries=$2 icd=$3 preload=${4:+--preload \"\$libraries/$4\"}
    mkdir "$dir/icd" "$dir/layers"
    relocatable_manifest "$dir/root/usr/share/vulkan/icd.d/$icd" "$dir/icd/$icd" "$libraries"
    relocatable_manifest "$dir/root/usr/share/vulkan/explicit_layer.d/VkLayer_khronos_validation.json" \
        "$dir/layers/VkLayer_khronos_validation.json" "$libraries"
    cat >"$dir/run" <<RUN
#!/bin/sh
# run PROGRAM ARGUMENTS...: $5. The program is started by the unpacked libc's
# loader, so that it and the driver agree on one libc.
here=\$(cd "\$(dirname "\$0")" && pwd)
libraries=\$here/$libraries
export $6
export VK_DRIVER_FILES="\$here/icd/$icd" VK_ICD_FILENAMES="\$here/icd/$icd"
export VK_LAYER_PATH="\${VK_LAYER_PATH-\$here/layers}" VK_LOADER_LAYERS_DISABLE="\${VK_LOADER_LAYERS_DISABLE-~implicit~}"
case \$1 in */*) program=\$1 ;; *) program=\$(command -v "\$1") || { echo "run: \$1: not found" >&2; exit 127; } ;; esac
shift
exec "\$libraries/ld-linux-x86-64.so.2" --library-path "\$libraries" $preload "\$program" "\$@"
RUN
    chmod +x "$dir/run"
}

# prove_system DIR LIBRARIES DRIVER NAME: the proof that it is whole: the driver's own loader finds every library, and the
# driver answers with a device of this name; prints what it is.
prove_system() {
    "$1/run" "$1/root/usr/bin/vulkaninfo" --summary >"$1/vulkaninfo.txt" 2>&1 || true
    if ! grep -q "deviceName *= *$4" "$1/vulkaninfo.txt"; then
        cat "$1/vulkaninfo.txt" >&2
        "$1/$2/ld-linux-x86-64.so.2" --library-path "$1/$2" --list "$1/$2/$3" | grep 'not found' >&2 || true
        die "the unpacked driver does not start (see above)"
    fi
    grep -E 'deviceName|driverInfo' "$1/vulkaninfo.txt" >&2
}

# A cache folder is complete when its stamp equals the checksum of the scripts that fill it.
cache_stamp() { cat "$0" "$ROOT/tools/lib.sh" | cksum; }
cache_is_complete() { [ "$(cat "$1/.complete" 2>/dev/null)" = "$(cache_stamp)" ]; }

# new_cache DIR: refuses a folder that is not such a cache, and prints a fresh folder beside it to fill.
new_cache() {
    if [ -e "$1" ] && [ ! -e "$1/.complete" ] && ! rmdir "$1" 2>/dev/null; then
        die "$1 exists and was not made by this script: remove it, or name another folder"
    fi
    mktemp -d "$1.XXXXXX"
}

# publish_cache NEW DIR: puts the filled folder in the place of the old one.
publish_cache() {
    chmod 755 "$1"
    cache_stamp >"$1/.complete"
    rm -rf "$2"
    mv -T "$1" "$2"
}
