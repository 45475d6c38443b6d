# Completion of voronoid for fish, made by voronoid --completion fish.

# Whether the words before the cursor are those of a command; of none without one.
function __voronoid_is
    set -l words (commandline -opc)
    set -e words[1]
    set -q words[1]; or return (count $argv)
    set -q argv[1]; or return 1
    test "$words[1]" = submit; and set -q words[2]; or set words $words[1]
    test "$words[1..2]" = "$argv"
end

# What stands before the last comma of a list stays.
function __voronoid_list
    set -l word (commandline -ct | string replace -r '^--[^=]*=' '')
    printf '%s\n' (string replace -r '[^,]*$' '' -- $word)$argv
end

function __voronoid_jobs
    set -l words (commandline -opc)
    timeout 2 $words[1] jobs -q 2>/dev/null
end

complete -c voronoid -f
complete -c voronoid -n '__voronoid_is' -a help -d 'Explain a command or a topic'
complete -c voronoid -n '__voronoid_is' -l help -d 'List the commands'
complete -c voronoid -n '__voronoid_is' -l version -d 'Print the version'
complete -c voronoid -n '__voronoid_is' -l completion -x -a 'bash zsh fish'
complete -c voronoid -n '__voronoid_is' -l man -x -a '1 8'
