#!/usr/bin/perl
# G31: what reading an upload in a child costs beside reading it on a thread, as tests/by_hand/torture/isolation.c measures it, before
# all else that runs where that is allowed: what others do meanwhile is not in the figure.
use strict;
use warnings;
use Getopt::Long;

GetOptions('long' => \my $long, 'seed=i' => \my $seed) or exit 2;
my $program = 'build/release/tests/by_hand/torture/isolation';
system("make -s $program >&2") == 0 or die "cannot build $program";
my $rounds = $long ? 51 : 5;
open my $in, '<', '/proc/loadavg' or die "/proc/loadavg: $!\n";
my ($load) = split ' ', readline $in;

# What reading takes longer, or computes more, in a child: a row each. Computing changes little with the load.
sub row {
    my ($what, $bytes, $count, $base, $more) = @_;
    my $small = $bytes <= 1 << 20;
    my $limit = $small ? 1 : 0.1 * $base;
    printf "G31\t%s (%s), %d times\t%s more than %.2f ms\t%s\t%s\n", $what, $small ? sprintf('%d KB', $bytes / 1000) : sprintf('%.1f MB', $bytes / 1e6),
        $count, $small ? sprintf('%.2f ms', $more) : sprintf('%.0f %%', 100 * $more / $base), $base, $small ? '1 ms' : '10 %',
        $more <= $limit ? 'ok' : 'short';
}
my $first = system('chrt -f 10 true 2>/dev/null') == 0 ? 'chrt -f 10' : '';
for (split /\n/, `$first $program $rounds`) {
    my ($name, $bytes, $thread, undef, $more, $here, $there) = split /\t/;
    my $count = $bytes < 2e6 ? 4 * $rounds : $rounds;
    row("child beside thread, $name, median, load $load", $bytes, $count, $thread, $more);
    row("the same, computing, $name, mean", $bytes, $count, $here, $there - $here);
}
die "$program failed" if $?;
