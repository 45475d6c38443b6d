#!/usr/bin/perl
# usage: run.pl [--long] [--seed N] [--count N] VORONOID: runs every figure of tests/by_hand/torture and prints one table, a row a
# figure, with date, machine, version and seed; build/torture/torture.md keeps it. ONLY (a regular expression) picks programs
# by name. --count, for some of them, is how many kills, bodies or requests; TORTURE_SECONDS ends their long forms after so
# long, with as many as were done by then.
#
# A program takes --long and --seed N, finds the daemon's binary in VORONOID, and prints a line a figure:
#     ID <tab> what was measured <tab> figure with unit <tab> figure wanted <tab> ok or short
# "short" is a figure that was not reached; the table says so, and only a program that could not measure fails the run. One
# that has a long form alone prints nothing without --long.
#
# Long forms take hours: figures.tsv keeps the last figure of each, with its date, version, seed and load, and the table has
# it beside the short one. --long writes it, program by program. before.tsv has what each finding (F..) was like.
use strict;
use warnings;
use Cwd qw(abs_path);
use File::Basename qw(basename dirname);
use File::Path qw(make_path);
use Getopt::Long;
use POSIX qw(strftime);
use Time::HiRes qw(time);

my $out = 'build/torture';
my $here = dirname(abs_path($0));
my ($long, $seed, $count, $only) = (0, 1, undef, $ENV{ONLY} // '');
GetOptions('long' => \$long, 'seed=i' => \$seed, 'count=i' => \$count) && @ARGV == 1
    or die "usage: run.pl [--long] [--seed N] [--count N] VORONOID\n";
$ENV{VORONOID} = abs_path($ARGV[0]) or die "$ARGV[0]: no such binary\n";

sub first_line { my $line = qx{$_[0]}; chomp $line; return $line }
my $version = first_line("$ENV{VORONOID} --version") . ' ' . first_line('git rev-parse --short HEAD 2>/dev/null');
my $today = strftime('%Y-%m-%d', gmtime);

# The lines of a table of ours, each a list of its columns.
sub table {
    my ($file) = @_;
    open my $in, '<', "$here/$file" or return;
    return map { chomp; [split /\t/, $_, -1] } grep {!/^#/} <$in>;
}

# "F5" and "F05" are one, as are figures whose sentences differ in numbers alone.
sub id_of { return $_[0] =~ s/^([A-Z]+)0*(\d+)/sprintf '%s%02d', $1, $2/er }
sub key_of { my ($program, $row) = @_; return join "\t", $program, id_of($row->[0]), $row->[1] =~ s/\d[\d.,]*/#/gr }

# The figures of one program, each with the seconds it took in all; what it printed that is none goes to standard error.
sub measure {
    my ($program) = @_;
    my ($began, @rows) = (time);

    open my $in, '-|', $program, ('--long') x !!$long, '--seed', $seed, defined $count ? ('--count', $count) : () or return "cannot start: $!";
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

# PROGRAM, ID, MEASURED, FIGURE, WANTED, ok or short, DATE, VERSION, SEED, LOAD of every figure of a long form.
my @kept = table('figures.tsv');

# Puts the figures of a program in the place of those that it had.
sub keep {
    my ($program, @rows) = @_;
    open my $load, '<', '/proc/loadavg' or die "/proc/loadavg: $!\n";
    my ($busy) = split ' ', readline $load;
    @kept = grep { $_->[0] ne $program } @kept;
    push @kept, map { [$program, id_of($_->[0]), @$_[1 .. 4], $today, $version, $seed, $busy] } @rows;
    open my $file, '>', "$here/figures.tsv" or die "figures.tsv: $!\n";
    print {$file} "# The last long form of each program: program, ID, what was measured, figure, wanted, verdict, date, version, seed, load\n";
    print {$file} map { join("\t", @$_) . "\n" } sort { "@$a[0 .. 2]" cmp "@$b[0 .. 2]" } @kept;
    close $file or die "figures.tsv: $!\n";
}

my (@rows, @broken);
for my $path (sort glob "$here/[fg][0-9]*.pl") {
    my $program = basename($path);
    next if $program !~ /$only/;
    my $got = measure($path);
    ref $got or push(@broken, "$program: $got"), next;
    keep($program, @$got) if $long;
    push @rows, map { { program => $program, row => $_ } } @$got;
}

# --- the table ------------------------------------------------------------------------------------

# Short and long figures of the same are one line.
my (%line, @lines);
sub line_of {
    my ($program, $row) = @_;
    my $key = key_of($program, $row);
    my $line = (grep { !$_->{ $_[2] } } @{ $line{$key} // [] })[0];
    return $line if $line;
    push @{ $line{$key} }, $line = { id => id_of($row->[0]), measured => $row->[1], wanted => $row->[3], at => scalar @lines };
    push @lines, $line;
    return $line;
}
if (!$long) {
    line_of($_->{program}, $_->{row}, 'short')->{short} = $_->{row} for @rows;
}
for my $kept (grep { $_->[0] =~ /$only/ } @kept) {
    line_of($kept->[0], [@$kept[1 .. 5]], 'long')->{long} = $kept;
}
@lines = sort { $a->{id} cmp $b->{id} || $a->{at} <=> $b->{at} } @lines;

my %before = map { ($_->[0] => $_->[1]) } table('before.tsv');
sub short_cells { my ($row) = @_; return $row ? @$row[2, 4, 5] : ('', '', '') }
sub long_cells {
    my ($line, $row) = @_;
    return ('', '', '') unless $row;
    my $figure = $row->[2] eq $line->{measured} ? $row->[3] : "$row->[3] ($row->[2])";
    return ($figure, $row->[5], "$row->[6], seed $row->[8], load $row->[9], $row->[7]");
}
sub cells { return '| ' . join(' | ', map { s/\|/\\|/gr } @_) . ' |' }

my %has = map { ($_->{id} => 1) } @lines;
my @without = grep { !$has{$_} } (map { sprintf 'F%02d', $_ } 1 .. 13), map { sprintf 'G%02d', $_ } 1 .. 17, 19 .. 31;
my @text = (
    sprintf('# %s, %s, seed %d', $long ? 'Long form' : 'Short form', $today, $seed), '',
    "$version; " . first_line('uname -srm') . '; ' . first_line('nproc') . ' cores', '',
    cells('', 'before', 'measured', 'wanted', 'short form', '', 's', 'last long form', '', 'of'), cells(('---') x 10));
for my $line (@lines) {
    my $before = delete $before{ $line->{id} } // ''; # once, in the first line of its finding
    push @text, cells($line->{id}, $before, $line->{measured}, $line->{wanted}, short_cells($line->{short}), long_cells($line, $line->{long}));
}
push @text, '', @without && !length $only ? "No figure here: @without" : (), map {"Not measured: $_"} @broken;
make_path($out);
open my $table, '>', "$out/torture.md" or die "$out/torture.md: $!\n";
print {$table} map {"$_\n"} @text;
close $table or die "$out/torture.md: $!\n";
print map {"$_\n"} @text;
exit(@broken || !@rows ? 1 : 0);
