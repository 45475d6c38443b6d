#!/usr/bin/perl
# Every reader of strangers' bytes under libFuzzer, ASan and UBSan, from the kept corpus: 600 s a target. Long form alone: it builds
# everything once more.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use List::Util qw(sum0);
use Faults;

my %option = options();
exit 0 unless $option{long};
chdir "$FindBin::Bin/../../..";
my $seconds = $ENV{FUZZ_SECONDS} // 600;
my @lines = qx{make --no-print-directory fuzz FUZZ_SECONDS=$seconds};
print STDERR @lines;
my @runs = map { /^fuzz \S+: \d+ s, (\d+) runs/ ? $1 : () } @lines;
my @found = glob 'build/fuzz/crash-*';
exit 1 unless @runs || @found;
figure('G5', scalar(@runs) . " targets, $seconds s each: executions", sum0(@runs), '>= 1e8 in all', sum0(@runs) >= 1e8);
figure('G5', 'crashes, leaks, hangs, too much memory', scalar(@found), 0);
