#compdef voronoid
# Completion of voronoid for zsh, made by voronoid --completion zsh.

_voronoid_jobs() {
  local -a jobs
  jobs=(${(f)"$(timeout 2 voronoid jobs -q 2>/dev/null)"})
  compadd -a jobs
}

_voronoid() {
  local -a commands
  local command
  if (( CURRENT == 2 )); then
    commands=('help:Explain a command' $_voronoid_commands)
    _describe -t commands command commands
    return
  fi
  command=$words[2]
  shift words
  (( CURRENT-- ))
  if [[ $command == submit ]]; then
    if (( CURRENT == 2 )); then
      compadd -a _voronoid_processes
      return
    fi
    command="submit $words[2]"
    shift words
    (( CURRENT-- ))
  fi
  _voronoid_options $command
}
