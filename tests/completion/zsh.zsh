#!/usr/bin/env zsh
# usage: zsh -f zsh.zsh TOOL COMPLETION
#   A shell of its own, in a terminal of its own, is asked for the completions of TOOL: every option that --help has,
#   and the choices of those that have some.
zmodload zsh/zpty || { print 'skipped: zsh has no zpty'; exit 0 }
tool=${1:a} completion=${2:A} name=${1:t} faults=0
folder=$(mktemp -d)
trap 'rm -rf $folder' EXIT
cp $completion $folder/_$name
cd $folder
touch run.csv robot.toml

# What completes is told by compadd, in a file.
cat >$folder/shell <<END
PS1=ready
fpath=($folder \$fpath)
autoload -Uz compinit && compinit -u -d $folder/dump
zstyle ':completion:*' menu no
compadd() {
  local -a found
  if [[ \${@[(I)-[OAD]*]} -gt 0 ]]; then builtin compadd "\$@"; return; fi
  builtin compadd -O found "\$@"
  print -rl -- \$found >>$folder/told
  builtin compadd "\$@"
}
complete_to_file() { zle complete-word; print >$folder/done }
zle -C whatever complete-word _main_complete
zle -N complete_to_file
bindkey '^I' complete_to_file
END

# completions LINE
completions() {
  rm -f $folder/told $folder/done
  zpty shell zsh -f -i
  zpty -w shell "source $folder/shell"
  zpty -n -w shell "$1"$'\t'
  local k
  for k in {1..200}; do [[ -e $folder/done ]] && break; sleep 0.05; done
  zpty -d shell
  [[ -e $folder/told ]] && cat $folder/told
}
expect() { # WHAT LINE
  [[ $told == *$'\n'$1$'\n'* ]] || { print -u2 -r -- "$name: '$2' is not completed with $1"; ((++faults)) }
}

told=$'\n'"$(completions "$name --")"$'\n'
checked=0
for option in ${(f)"$($tool --help | grep -E '^ +(-[a-z], *)?--[a-z]' | grep -oE -- '^ +(-[a-z], *)?--[a-z-]+' | grep -oE -- '--[a-z-]+')"}; do
  expect $option "$name --"
  ((++checked))
done
((checked >= 3)) || { print -u2 "$name: only $checked options found in --help"; ((++faults)) }
for line in ${(f)"$($tool --help | grep -E '^ +--[a-z-]+ [a-z_]+[|]')"}; do
  words=(${(s: :)line})
  option=$words[1]
  told=$'\n'"$(completions "$name $option ")"$'\n'
  for choice in ${(s:|:)words[2]}; do expect $choice "$name $option "; done
done
if $tool --help | grep -q " experiment EXPERIMENT.toml"; then
  told=$'\n'"$(completions "$name ")"$'\n'
  expect robot.toml "$name "
  [[ $told != *run.csv* ]] || { print -u2 "$name: completes an experiment with run.csv"; ((++faults)) }
fi
((faults == 0)) || exit 1
print "$name: $checked options are completed"
