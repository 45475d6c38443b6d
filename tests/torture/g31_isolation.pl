#!/usr/bin/perl
# G31: what reading an upload in a child costs beside reading it on a thread, as tests/torture/isolation.c measures it.
use strict;
use warnings;
use Getopt::Long;

GetOptions('long' => \my $long, 'seed=i' => \my $seed) or exit 2;
my $program = 'build/release/tests/torture/isolation';
system("make -s $program >&2") == 0 or die "cannot build $program";
my $rounds = $long ? 51 : 5;
for (split /\n/, `$program $rounds`) {
    my ($name, $bytes, $thread, $child, $more) = split /\t/;
    if ($bytes <= 1 << 20) {
        printf "G31\tchild beside thread, %s (%d KB), median of %d\t%.2f ms more than %.2f\t1 ms\t%s\n", $name, $bytes / 1000,
            $rounds * 4, $more, $thread, $more <= 1 ? 'ok' : 'short';
    } else {
        printf "G31\tchild beside thread, %s (%.1f MB), median of %d\t%.1f %% more than %.1f ms\t10 %%\t%s\n", $name, $bytes / 1e6,
            $rounds, 100 * $more / $thread, $thread, $more <= 0.1 * $thread ? 'ok' : 'short';
    }
}
die "$program failed" if $?;
