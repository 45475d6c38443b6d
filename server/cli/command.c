#include "server/cli/command.h"

#include <assert.h>

static const struct vor_option_info options[VOR_OPTION_COUNT] = {
#define OPTION_ROW(id, name, letter, value, variable, commands, sentence)                          \
    {name, value, variable, sentence, commands, letter},
    VOR_OPTION_TABLE(OPTION_ROW)
#undef OPTION_ROW
};

const struct vor_option_info *vor_option_info(enum vor_option option)
{
    assert((unsigned)option < VOR_OPTION_COUNT);
    return &options[option];
}

int vor_command_takes(const struct vor_command *command, enum vor_option option)
{
    if (option == VOR_OPTION_PRESET &&
        (command->process == NULL || vor_named_preset(command->process->id, 0) == NULL))
        return 0;
    return (vor_option_info(option)->commands & command->does) != 0;
}
