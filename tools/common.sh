# shellcheck shell=bash
# Read by the scripts in this folder: where the project is, how they speak, how they install.

tools=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(dirname "$tools")

# Where the system's meson is too old, tools/setup has put one here.
[ ! -x "$root/.venv/bin/meson" ] || PATH=$root/.venv/bin:$PATH

# The comment at the top of a script is its --help.
help() { sed -n '2,/^[^#]/{s/^# \{0,1\}//p;}' "$0"; }

say() { printf '%s: %s\n' "${0##*/}" "$*" >&2; }

# die CODE MESSAGE
die() {
  local code=$1
  shift
  say "$*"
  exit "$code"
}

# needs_value OPTION [VALUE]: an option's value must be there.
needs_value() { [ $# -ge 2 ] || die 2 "$1 needs a value; see tools/${0##*/} --help"; }

# quietly LOG COMMAND...: output goes to LOG; when COMMAND fails, the end of LOG is shown.
quietly() {
  local log=$1 code=0
  shift
  mkdir -p "$(dirname "$log")"
  "$@" </dev/null >"$log" 2>&1 || code=$?
  [ "$code" -eq 0 ] && return
  tail -n 40 "$log" >&2
  say "failed with code $code: $* (the whole log is $log)"
  return "$code"
}

# install_packages NAME...: by apt-get where that is allowed, else the line to type and exit 3.
install_packages() {
  local as_root=()
  command -v apt-get >/dev/null ||
    die 3 "please install what these Debian packages hold, then try again: $*"
  if [ "$(id -u)" -ne 0 ]; then
    if ! sudo -n true 2>/dev/null; then
      say "some packages are missing. Type this line, then try again:"
      echo "sudo apt-get update && sudo apt-get install -y --no-install-recommends $*" >&2
      exit 3
    fi
    as_root=(sudo -n)
  fi
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300)
  say "installing $*"
  quietly "$root/build/apt.log" "${apt[@]}" update || exit 3
  quietly "$root/build/apt.log" "${apt[@]}" install -y --no-install-recommends "$@" || exit 3
}
