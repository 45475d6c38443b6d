package Torture;

# What the programs of this folder share: their options, a row of the table, percentiles, seeded choices, many sockets.
use strict;
use warnings;
use Getopt::Long;

# --long and --seed N: the long form or not, and the seed.
sub options {
    my ($long, $seed) = (0, 1);
    GetOptions('long' => \$long, 'seed=i' => \$seed) or exit 2;
    srand $seed;
    $| = 1;
    return ($long, $seed);
}

# A number in [0, 1) that follows from the seed and how often it was asked for.
sub random { return rand }

# A line of the table: what it is of, what was measured, the figure, what is wanted, whether it holds.
sub row {
    my ($id, $what, $figure, $wanted, $holds) = @_;
    print join("\t", $id, $what, $figure, $wanted, $holds ? 'ok' : 'short'), "\n";
}

# The value below which that share of the values lies.
sub percentile {
    my ($share, @values) = @_;
    @values = sort { $a <=> $b } @values;
    return @values ? $values[int($share * $#values + 0.5)] : 0;
}

# Runs this program again with as many open files as it may have, if they are fewer than wanted; returns how many there are.
sub files {
    my ($wanted) = @_;
    my $now = `ulimit -n` + 0;
    return $now if $now >= $wanted || $ENV{TORTURE_FILES};
    $ENV{TORTURE_FILES} = 1;
    exec 'bash', '-c', "ulimit -n $wanted 2>/dev/null || ulimit -n \$(ulimit -Hn); exec \"\$@\"", 'bash', $^X, $0, @main::ARGV_WAS;
}

sub load { open my $file, '<', '/proc/loadavg' or return '?'; return (split ' ', <$file>)[0] }

1;
