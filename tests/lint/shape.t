#!/usr/bin/perl
# The shape of the code: files of at most 600 lines (core/engine.c, which only strings rooms together: under 300), functions of
# at most 70 and with at most six parameters, no words of unfinished work, the top level as agreed.
use strict;
use warnings;
use Test::More;

my @all = split /\n/, `git ls-files -co --exclude-standard`;
my @sources = grep { m{^(?:core|proto|server|docker)/.*\.(?:[ch]|cc)$} && -f } @all;
my (@long_files, @long_functions, @unfinished);
for my $file (@sources) {
    open my $in, '<', $file or next;
    my ($open, $name) = (0, '');
    while (my $line = <$in>) {
        $name = $line if $line =~ /^[a-zA-Z_].*\)\s*$/;
        $open = $. if $line =~ /^\{/;
        if ($line =~ /^\}/ && $open) {
            push @long_functions, "$file:$open: " . ($. - $open) . ' lines' if $. - $open > 70;
            $open = 0;
        }
        push @unfinished, "$file:$." if $line =~ /\b(?:TODO|FIXME|XXX)\b|not implemented|for now\b/i;
        push @unfinished, "$file:$.: line comment" if $file =~ /\.[ch]$/ && $line =~ m{(?:^|\s)//\s};
    }
    push @long_files, "$file: $. lines" if $. > ($file eq 'core/engine.c' ? 300 : 600);
    close $in;
}
is("@long_files", '', 'no file is longer than its limit');
is("@long_functions", '', 'no function is longer than 70 lines');
is("@unfinished", '', 'nothing says that it is unfinished');

# Beside the run and the error, which nearly every function that may fail has. Comments and inner parentheses do not count.
sub crowded {
    my ($text) = @_;
    my @found;
    $text =~ s{/\*.*?\*/}{}gs;
    while ($text =~ /^[A-Za-z_][\w *]*?[ *](\w+)\(([^;{}()]*(?:\([^()]*\)[^;{}()]*)*)\)\s*[;{]/mg) {
        my ($name, $list) = ($1, $2);
        $list =~ s/\([^()]*\)//g;
        my @parameters = grep { !/\bstruct vor_(?:error|run) \*/ } split /,/, $list;
        push @found, "$name: " . @parameters if @parameters > 6;
    }
    return @found;
}
my @crowded;
for my $file (grep { !m{^server/(?:http/mhd_callbacks|base/flann_library)\.} } @sources) { # as libmicrohttpd and FLANN have it
    open my $in, '<', $file or next;
    local $/;
    push @crowded, map { "$file: $_" } crowded(scalar <$in>);
}
is("@crowded", '', 'no function has more than six parameters');
is(scalar(crowded("static int f(int a, int b, int c,\n int d, int e, int g, int h)\n{\n")), 1, 'one of seven would be found');
is(scalar(crowded("int f(int a, int b, int c, int d, int e, int g, const struct vor_run *run, struct vor_error *err);\n")), 0,
    'the run and the error are no such');

my @long_tests;
for my $file (grep { m{^tests/(?!by_hand/).*\.(?:[ch]|cc|t|pl|pm|py|sh)$} && -f } @all) {
    open my $in, '<', $file or next;
    1 while <$in>;
    push @long_tests, "$file: $. lines" if $. > 600;
}
is("@long_tests", '', 'no test file is longer than 600 lines');

my %allowed = map { $_ => 1 } qw(Makefile server core proto tests docker openapi.yaml README.md ARCHITECTURE.md
    CHANGELOG.md LICENSE);
my %top;
for my $path (@all) {
    my ($first) = split m{/}, $path;
    $top{$first} = 1 unless $allowed{$first} || $first =~ /^\./;
}
is(join(' ', sort keys %top), '', 'the top level holds only what was agreed');
done_testing();
