#include "server/cli/menu.h"

#include <string.h>

enum { POINTS_LETTER = 'n' /* stands for the parameter points */ };

static void add_long(struct vor_menu *menu, const char *name, int argument, int value)
{
    menu->longs[menu->count++] = (struct option){name, argument, NULL, value};
}

static void add_letter(struct vor_menu *menu, char letter, int has_value)
{
    size_t at = strlen(menu->letters);

    menu->letters[at++] = letter;
    if (has_value)
        menu->letters[at++] = ':';
    menu->letters[at] = '\0';
}

enum vor_parameter vor_menu_parameter(const char *name)
{
    char option[VOR_REFERENCE_NAME_SIZE];
    int i = 0;

    for (; i < VOR_PARAMETER_COUNT; i++) {
        enum vor_parameter parameter = (enum vor_parameter)i;

        if (strcmp(name, vor_parameter_info(parameter)->name) == 0 ||
            strcmp(name, vor_reference_option(option, parameter)) == 0)
            break;
    }
    return (enum vor_parameter)i;
}

static void add_parameters(struct vor_menu *menu, const struct vor_process_info *process)
{
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++) {
        const struct vor_parameter_info *info = vor_parameter_info((enum vor_parameter)i);
        int argument = info->kind == VOR_KIND_FLAG ? optional_argument : required_argument;

        if (!vor_process_takes(process, (enum vor_parameter)i))
            continue;
        add_long(menu, vor_reference_option(menu->parameters[i], (enum vor_parameter)i), argument,
                 VOR_LONG_PARAMETER + i);
        if (strcmp(menu->parameters[i], info->name) != 0)
            add_long(menu, info->name, argument, VOR_LONG_PARAMETER + i);
    }
    if (vor_process_takes(process, VOR_PARAM_POINTS))
        add_letter(menu, POINTS_LETTER, 1);
}

/* "-" has operands come in their order, whatever POSIXLY_CORRECT says; ":" tells a missing value
 * from an unknown option, and prints nothing. */
void vor_menu_make(struct vor_menu *menu, const struct vor_command *command)
{
    memset(menu, 0, sizeof *menu);
    memcpy(menu->letters, "-:", sizeof "-:");
    for (int i = 0; i < VOR_OPTION_COUNT; i++) {
        const struct vor_option_info *info = vor_option_info((enum vor_option)i);
        int has_value = info->value[0] != '\0';

        if (!vor_command_takes(command, (enum vor_option)i))
            continue;
        add_long(menu, info->name, has_value ? required_argument : no_argument,
                 VOR_LONG_OPTION + i);
        if (info->letter != 0)
            add_letter(menu, info->letter, has_value);
    }
    if (command->process == NULL)
        return;
    for (int i = 1; command->process->inputs[i].name != NULL; i++)
        add_long(menu, command->process->inputs[i].name, required_argument, VOR_LONG_INPUT + i);
    add_parameters(menu, command->process);
}
