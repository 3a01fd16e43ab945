#!/usr/bin/env bash
# Installs Farhand's services into /opt/farhand, /etc/farhand and systemd, or removes them; asks nothing, may run again.
set -euo pipefail

usage="usage: deploy/install.sh [--uninstall] [--dry-run] [--root DIR]
  --uninstall  remove everything but edited configuration and files of others in Farhand's folders
  --dry-run    only print what would be done
  --root DIR   install below DIR, for an image or a trial: no user is made, systemd is not called
The environment variable PYTHON chooses the interpreter, python3 by default; Farhand needs Python 3.11 or newer."

source=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
python=${PYTHON:-python3}
packages=(common local_site remote_site farhand)
groups=(video render dialout)
action=install_all dry= root=

main() {
  read_arguments "$@"
  home=$root/opt/farhand
  configuration=$root/etc/farhand
  state=$root/var/lib/farhand
  cache=$root/var/cache/farhand
  units=$root/usr/local/lib/systemd/system
  command=$root/usr/local/bin/farhand
  check
  "$action"
}

read_arguments() {
  while [ $# -gt 0 ]; do
    case $1 in
      --uninstall) action=uninstall_all ;;
      --dry-run) dry=yes ;;
      --root) [ $# -gt 1 ] || fail "--root needs a folder" 2; root=$(realpath -m -- "$2"); shift ;;
      --root=*) root=$(realpath -m -- "${1#--root=}") ;;
      --help | -h) echo "$usage"; exit 0 ;;
      *) echo "$usage" >&2; exit 2 ;;
    esac
    shift
  done
  if [ "$root" = / ]; then root=; fi
}

fail() {
  echo "install.sh: $1" >&2
  exit "${2:-1}"
}

# Do it, or with --dry-run print it.
run() {
  if [ -n "$dry" ]; then echo "would run: $*"; else "$@"; fi
}

check() {
  if [ -z "$root$dry" ] && [ "$(id -u)" -ne 0 ]; then
    fail "only root may write to /opt and /etc: sudo deploy/install.sh, or try it with --root DIR"
  fi
  # A running service may be moving an arm.
  local unit
  for unit in "$source"/farhand/deployment/systemd/*.service; do
    unit=$(basename "$unit")
    if systemd_runs && systemctl --quiet is-active "$unit"; then
      fail "$unit is running: systemctl stop $unit"
    fi
  done
}

systemd_runs() { [ -z "$root" ] && [ -d /run/systemd/system ]; }

# Python is called with -I: root may stand in a folder of somebody else's, and nothing there is imported.
install_all() {
  "$python" -I -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
    fail "Farhand needs Python 3.11 or newer: PYTHON=/path/to/python3.11 deploy/install.sh"
  "$python" -I -c 'import ensurepip' 2>/dev/null ||
    fail "Python lacks its venv module; on Debian: apt-get install python3-venv"
  check_visible
  make_user
  copy_source
  make_environment
  place_configuration
  place_units
  compile
  if [ -n "$dry" ]; then return; fi
  echo "Farhand is installed. Next:
  edit $configuration/remote.toml or local.toml, then: farhand doctor --config FILE
  sudo -u farhand env CACHE_DIRECTORY=$cache farhand models install
                                           (only for tracking.method = \"learned\")
  systemctl enable --now farhand-remote    (the robot's side)
  systemctl enable --now farhand-local     (the operator's side)"
}

check_visible() {
  if [ -n "$root" ]; then return; fi
  local prefix
  prefix=$("$python" -I -c 'import os, sys; print(os.path.realpath(sys.base_prefix))')
  case $prefix/ in
    /home/* | /root/* | /run/user/*)
      fail "home folders are hidden from the services, and this Python is in $prefix: PYTHON=/usr/bin/python3 deploy/install.sh" ;;
  esac
}

make_user() {
  if [ -n "$root" ]; then return; fi
  if ! getent passwd farhand >/dev/null; then
    run useradd --system --user-group --home-dir "$state" --no-create-home --shell /usr/sbin/nologin farhand
  fi
  local group
  for group in "${groups[@]}"; do
    if getent group "$group" >/dev/null; then run usermod --append --groups "$group" farhand; fi
  done
  run install --directory --owner farhand --group farhand --mode 0755 "$state" "$cache"
}

# pip builds from a copy, so that the source folder stays unchanged.
copy_source() {
  run rm -rf "$home/source" "$home/docs"
  run mkdir -p "$home/source"
  local package
  for package in "${packages[@]}" pyproject.toml constraints.txt README.md LICENSE; do
    run cp -R "$source/$package" "$home/source/"
  done
  run cp -R "$source/docs" "$home/docs"
}

make_environment() {
  local venv=$home/.venv
  if ! "$venv/bin/python" -I -c '' 2>/dev/null; then run "$python" -I -m venv --clear "$venv"; fi
  run "$venv/bin/python" -I -m pip install --quiet --disable-pip-version-check \
    --constraint "$home/source/constraints.txt" "$home/source[sim,video,learned]"
  run rm -rf "$home/source/build"
  if [ -n "$root" ]; then
    # Scripts name their interpreter by its path once DIR is the root.
    run find "$venv/bin" -type f -exec sed -i "1s|^#!$root/|#!/|" {} +
  fi
  run mkdir -p "$(dirname "$command")"
  run ln -sfn /opt/farhand/.venv/bin/farhand "$command"
}

# A newer file replaces one that is unchanged since its installation, never an edited one.
place_configuration() {
  run mkdir -p "$configuration" "$home/configuration"
  local shipped name installed
  for shipped in "$source"/farhand/deployment/sites/*.toml; do
    name=$(basename "$shipped") installed=$configuration/$(basename "$shipped")
    if [ ! -e "$installed" ] || is_untouched "$name"; then
      run cp "$shipped" "$installed"
    elif ! cmp -s "$shipped" "$installed" && ! cmp -s "$shipped" "$home/configuration/$name"; then
      run cp "$shipped" "$installed.new"
      echo "kept: $installed is edited; this release's own is beside it as $name.new"
    fi
    run cp "$shipped" "$home/configuration/$name"
  done
  # For editors: each file names its schema, as seen from its own folder.
  run "$home/.venv/bin/python" -I -m farhand config schema --out "$configuration/schemas"
  keep_token
}

# The word that opens the page stands in it: for root and the services alone, also where an older release left it open.
keep_token() {
  run chmod 0640 "$configuration/console.toml"
  if [ -z "$root" ]; then
    run chgrp farhand "$configuration/console.toml"
  elif [ -z "$dry" ]; then
    echo "once the image has the user farhand: chgrp farhand /etc/farhand/console.toml"
  fi
}

is_untouched() { cmp -s "$configuration/$1" "$home/configuration/$1"; }

place_units() {
  run mkdir -p "$units"
  run cp "$source"/farhand/deployment/systemd/*.service "$units/"
  if systemd_runs; then run systemctl daemon-reload; fi
}

# Spares the first start a minute. An image is compiled at its first start, for the machine that it runs on.
compile() {
  if [ -n "$root" ]; then return; fi
  if [ -z "$dry" ]; then echo "Compiling the tracker (once, up to a minute) ..."; fi
  run runuser --user farhand -- env --chdir "$state" NUMBA_CACHE_DIR="$cache/numba" \
    "$home/.venv/bin/python" -I -m local_site.runtime.warm_up
}

uninstall_all() {
  remove_units
  remove_configuration
  run rm -rf "$home" "$cache"
  if [ -L "$command" ]; then run rm -f "$command"; fi
  run rm -rf "$state/unfinished" "$state/.cache"
  remove_if_empty "$configuration"
  remove_if_empty "$state"
  remove_user
}

remove_units() {
  local unit
  for unit in "$source"/farhand/deployment/systemd/*.service; do
    unit=$(basename "$unit")
    # An older release may lack it, and so does a second run.
    if systemd_runs && [ -e "$units/$unit" ]; then run systemctl --quiet disable "$unit"; fi
    run rm -f "$units/$unit"
  done
  if systemd_runs; then run systemctl daemon-reload; fi
}

remove_configuration() {
  local given name
  for given in "$home"/configuration/*.toml; do
    name=$(basename "$given")
    if is_untouched "$name"; then run rm -f "$configuration/$name"; fi
    run rm -f "$configuration/$name.new"
  done
  run rm -rf "$configuration/schemas"
}

# Whoever got its number next would own its keys and recordings.
remove_user() {
  if [ -n "$root" ] || ! getent passwd farhand >/dev/null; then return; fi
  if [ -d "$configuration" ] || [ -d "$state" ]; then
    echo "left: the user farhand, since files of it may be left"
  else
    run userdel farhand
  fi
}

remove_if_empty() {
  if [ -z "$(ls -A "$1" 2>/dev/null)" ]; then
    if [ -d "$1" ]; then run rmdir "$1"; fi
  else
    echo "left: $1 holds $(ls -A "$1" | tr '\n' ' ')"
  fi
}

main "$@"
