#!/usr/bin/env bash
# usage: bash.sh TOOL COMPLETION
#   Every option that TOOL --help has is completed, with its choices and files; so are those of its subcommands.
set -euo pipefail
tool=$(realpath -s "$1")
name=$(basename "$tool")
# What its help calls it.
called=$(sed "s/^rivid_identify$/rivid/; s/^rivid_montecarlo$/rivid study/; s/_/ /" <<<"$name")
faults=0
fault() { echo "$name: $1" >&2; faults=$((faults + 1)); }
# shellcheck disable=SC1090
source "$2"

# complete_words WORD…: what completes the last word, one a line.
complete_words() {
  COMP_WORDS=("$@")
  COMP_CWORD=$(($# - 1))
  COMPREPLY=()
  "_$name" "$name" "${*: -1}" ''
  printf '%s\n' "${COMPREPLY[@]}"
}
expect() { # WHAT WORD…: among the completions of these words
  local what=$1
  shift
  complete_words "$@" | grep -xF -- "$what" >/dev/null || fault "'$*' is not completed with $what"
}
refuse() {
  local what=$1
  shift
  if complete_words "$@" | grep -xF -- "$what" >/dev/null; then fault "'$*' is completed with $what"; fi
}

# check_options SUBCOMMAND…: the lines of --help that begin with an option.
checked=0
check_options() {
  local line option choice
  while IFS= read -r line; do
    option=$(grep -oE -- '--[a-z][a-z-]*' <<<"$line" | head -n 1)
    expect "$option" "$name" "$@" --
    checked=$((checked + 1))
    if [[ $line =~ \ ([a-z_]+(\|[a-z_]+)+) ]]; then
      for choice in ${BASH_REMATCH[1]//|/ }; do
        expect "$choice" "$name" "$@" "$option" ''
        expect "$choice" "$name" "$@" "$option" = "${choice:0:2}"
      done
    fi
  done < <("$tool" "$@" --help | grep -E '^ +(-[a-z], *)?--[a-z]')
}
check_options
for command in $("$tool" --help | grep -oE "$called [a-z]+ [A-Z]" | sed "s/^$called //; s/ .*//" | sort -u); do
  expect "$command" "$name" "${command:0:1}"
  check_options "$command"
done
((checked >= 3)) || fault "only $checked options found in --help"

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
mkdir runs
touch 'my robot.toml' run.csv
if "$tool" --help | grep -q " experiment EXPERIMENT.toml"; then
  expect 'my robot.toml' "$name" ''
  expect runs "$name" ''
  refuse run.csv "$name" ''
fi
if "$tool" --help | grep -q -- '--log FILE'; then
  expect run.csv "$name" 'my robot.toml' --log ''
  expect run.csv "$name" 'my robot.toml' --log run.csv ''
fi
if "$tool" --help | grep -q "$called init"; then
  touch robot.urdf
  expect robot.urdf "$name" init ''
  expect run.csv "$name" init robot.urdf ''
  expect torque_sign "$name" explain torque_
fi
if "$tool" --help | grep -q -- '--output DIR'; then
  expect runs "$name" --output ''
  refuse run.csv "$name" --output ''
fi
((faults == 0)) || exit 1
echo "$name: $checked options are completed"
