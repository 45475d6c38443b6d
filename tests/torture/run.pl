#!/usr/bin/perl
# usage: run.pl [--long] [--seed N] VORONOID: runs every figure of tests/torture and prints one table, a row a figure, with
# date, machine, version and seed; build/torture/torture.md keeps it. ONLY (a regular expression) picks programs by name.
#
# A program takes --long and --seed N, finds the daemon's binary in VORONOID, and prints a line a figure:
#     ID <tab> what was measured <tab> figure with unit <tab> figure wanted <tab> ok or short
# "short" is a figure that was not reached; the table says so, and only a program that could not measure fails the run. One
# that has a long form alone prints nothing without --long.
use strict;
use warnings;
use Cwd qw(abs_path);
use File::Basename qw(basename dirname);
use File::Path qw(make_path);
use Getopt::Long;
use POSIX qw(strftime);
use Time::HiRes qw(time);

my $out = 'build/torture';
my ($long, $seed, $only) = (0, 1, $ENV{ONLY} // '');
GetOptions('long' => \$long, 'seed=i' => \$seed) && @ARGV == 1 or die "usage: run.pl [--long] [--seed N] VORONOID\n";
$ENV{VORONOID} = abs_path($ARGV[0]) or die "$ARGV[0]: no such binary\n";

sub first_line { my $line = qx{$_[0]}; chomp $line; return $line }

# The figures of one program, each with the seconds it took in all; what it printed that is none goes to standard error.
sub measure {
    my ($program) = @_;
    my ($began, @rows) = (time);

    open my $in, '-|', $program, ('--long') x !!$long, '--seed', $seed or return "cannot start: $!";
    while (my $line = <$in>) {
        chomp $line;
        my @row = split /\t/, $line, -1;
        if (@row == 5 && $row[4] =~ /^(?:ok|short)$/) {
            push @rows, \@row;
            printf STDERR "%-5s %-60s %s\n", @row[0, 1, 2];
        } else {
            print STDERR "      $line\n";
        }
    }
    close $in or return 'ended with ' . ($? >> 8 || "signal $?");
    return $long ? 'printed no figure' : [] unless @rows;
    $_->[5] = sprintf '%.0f', time - $began for @rows;
    return \@rows;
}

sub by_id { my ($x, $y) = map { sprintf '%s%06d', /^(\D*)(\d*)/ ? ($1, $2 || 0) : ($_, 0) } $_[0][0], $_[1][0]; $x cmp $y }

my (@rows, @broken, @later);
for my $program (sort glob dirname(abs_path($0)) . '/[fg][0-9]*.pl') {
    next if basename($program) !~ /$only/;
    my $got = measure($program);
    push @later, basename($program) if ref $got && !@$got;
    ref $got ? push(@rows, @$got) : push(@broken, basename($program) . ": $got");
}
@rows = sort { by_id($a, $b) } @rows;

my @lines = (
    sprintf('# %s form, %s, seed %d', $long ? 'Long' : 'Short', strftime('%Y-%m-%d', gmtime), $seed), '',
    first_line("$ENV{VORONOID} --version") . '; ' . first_line('uname -srm') . '; ' . first_line('nproc') . ' cores', '',
    '| | measured | figure | wanted | | s |', '|---|---|---|---|---|---|',
    (map { '| ' . join(' | ', map { s/\|/\\|/gr } @$_) . ' |' } @rows), '',
    (@later ? "In the long form alone: @later" : ()), (map { "Not measured: $_" } @broken));
make_path($out);
open my $table, '>', "$out/torture.md" or die "$out/torture.md: $!\n";
print {$table} map { "$_\n" } @lines;
close $table or die "$out/torture.md: $!\n";
print map { "$_\n" } @lines;
exit(@broken || !@rows ? 1 : 0);
