# Completion of polyrad for bash. Commands and options are those of `polyrad --help`, asked each time.

_polyrad() {
  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]} verb=${COMP_WORDS[1]} help
  COMPREPLY=()
  help=$("${COMP_WORDS[0]}" --help 2>/dev/null) || return
  if [ "$COMP_CWORD" -eq 1 ]; then
    mapfile -t COMPREPLY < <(compgen -W "$(awk '/^[a-z]+  /{print $1}' <<<"$help") --help --version" -- "$cur")
    return
  fi
  case $prev in
    --threads) mapfile -t COMPREPLY < <(compgen -W "$(seq "$(nproc)")" -- "$cur") && return ;;
    --set | --task | --part | --tasks) return ;;
  esac
  if [[ $cur == -* ]]; then
    # the synopsis of the command: its line and those that are indented further
    mapfile -t COMPREPLY < <(compgen -W "--help $(awk -v verb="$verb" '
      /^  polyrad /{inside = $2 == verb} /^ {8}/ || /^  polyrad /{if (inside) print} /^$/{inside = 0}' <<<"$help" |
      grep -oE -- '(^|[^a-zA-Z-])--?[a-z][a-z-]*' | grep -oE -- '--?[a-z].*')" -- "$cur")
    return
  fi
  local pattern='*.@(yml|yaml)'
  [[ $verb != info ]] || pattern='*.@(vtkhdf|h5)'
  [[ $prev != -* || $prev == --quiet ]] || pattern='*'
  mapfile -t COMPREPLY < <(shopt -s extglob; compgen -d -- "$cur"; compgen -f -X "!$pattern" -- "$cur")
}

complete -o filenames -F _polyrad polyrad
