# Completion of voronoid for bash, made by voronoid --completion bash.
# shellcheck shell=bash disable=SC2207

_voronoid_reply()
{
    local IFS=$'\n'
    COMPREPLY=($(compgen "$@"))
}

_voronoid_operand()
{
    case $1 in
    wait | fetch | cancel | stop | jobs)
        _voronoid_reply -W "$(timeout 2 "${COMP_WORDS[0]}" jobs -q 2>/dev/null)" -- "$2" ;;
    health | serve | submit) ;;
    help) _voronoid_reply -W "${_voronoid_commands// /$'\n'}" -- "$2" ;;
    *)
        compopt -o filenames 2>/dev/null
        _voronoid_reply -f -- "$2" ;;
    esac
}

# COMMAND OPTION WORD SIGN: what may follow the option; SIGN is 1 behind a =.
_voronoid_follow()
{
    local kind words
    read -r kind words <<<"$(_voronoid_values "$1 $2")"
    words=${words// /$'\n'}
    case $kind in
    @file | @folder)
        compopt -o filenames 2>/dev/null
        if [ "$kind" = @file ]; then _voronoid_reply -f -- "$3"; else _voronoid_reply -d -- "$3"; fi ;;
    @word) _voronoid_reply -W "$words" -- "$3" ;;
    @list)
        local before=''
        [[ $3 != *,* ]] || before=${3%,*},
        _voronoid_reply -P "$before" -W "$words" -- "${3##*,}" ;;
    @flag)
        [ "$4" = 1 ] || return 1
        _voronoid_reply -W "$words" -- "$3" ;;
    @any) ;;
    *) return 1 ;;
    esac
}

_voronoid()
{
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} sign=0
    local command=${COMP_WORDS[1]}
    COMPREPLY=()
    if [ "$COMP_CWORD" -eq 1 ]; then
        _voronoid_reply -W "${_voronoid_commands// /$'\n'}"$'\nhelp\n--help\n--version\n--completion\n--man' -- "$word"
        return
    fi
    case $command in
    --completion) _voronoid_reply -W $'bash\nzsh\nfish' -- "$word"; return ;;
    --man) _voronoid_reply -W $'1\n8' -- "$word"; return ;;
    submit)
        if [ "$COMP_CWORD" -eq 2 ]; then
            _voronoid_reply -W "${_voronoid_processes// /$'\n'}" -- "$word"
            return
        fi
        command="submit ${COMP_WORDS[2]}" ;;
    esac
    if [ "$word" = = ]; then
        word='' sign=1
    elif [ "$before" = = ]; then
        before=${COMP_WORDS[COMP_CWORD - 2]} sign=1
    fi
    if _voronoid_follow "$command" "$before" "$word" "$sign"; then
        return
    elif [[ $word == -* ]]; then
        local names
        names=$(_voronoid_names "$command")
        _voronoid_reply -W "${names// /$'\n'}" -- "$word"
    else
        _voronoid_operand "$command" "$word"
    fi
}

complete -F _voronoid voronoid
