#!/usr/bin/perl
# usage: waiting.pl VORONOID OUTDIR: how right the daemon's estimate of the time left is. Jobs of 5 s and more are asked for their
# status all the time; at 20, 40, 60 and 80 % of the time that the job took, the estimate stands beside what was left. Writes
# OUTDIR/waiting.md.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench', 'tests/support';
use Bench;
use File::Temp qw(tempdir);
use HTTP::Tiny;
use JSON::PP;
use Time::HiRes qw(sleep time);

my $out = begin('Waiting');
my @shares = (0.2, 0.4, 0.6, 0.8);
my $least = 5;       # s: shorter jobs do not count
my $every = 0.05;    # s from one question to the next
my @rows = (
    ['bunny, upsample', public('bunny'), '/v1/upsample?ratio=4'],
    ['bunny, plain', public('bunny'), '/v1/resample?points=40000&polish=0'],
    ['igea30k, upsample', made('igea30k'), '/v1/upsample?ratio=4'],
    ['igea30k, denoise', made('igea30k'), '/v1/denoise?ratio=2'],
    ['igea134k', public('igea_mesh'), '/v1/resample?points=60000'],
    ['igea134k, plain', public('igea_mesh'), '/v1/resample?points=30000&polish=0'],
    ['igea655k', made('igea655k'), '/v1/resample?points=100000'],
    ['igea655k_noisy, denoise', made('igea655k_noisy'), '/v1/denoise?points=50000'],
    ['cow110k', made('cow110k'), '/v1/resample?points=80000'],
    ['cow110k_uneven, denoise', made('cow110k_uneven'), '/v1/denoise?ratio=1'],
    ['cow110k, plain', made('cow110k'), '/v1/resample?points=30000&polish=0'],
    ['cow20k, upsample', made('cow20k'), '/v1/upsample?ratio=4'],
    ['armadillo43k, upsample', public('armadillo_mesh'), '/v1/upsample?ratio=3'],
    ['armadillo_half, 40 iterations', made('armadillo_half'), '/v1/resample?points=50000&iterations=40&polish=50'],
    ['armadillo vox120k, upsample', made('armadillo_vox120k'), '/v1/upsample?points=240000'],
    ['armadillo5m_uneven', made('armadillo5m_uneven'), '/v1/resample?points=50000'],
    ['autzen', public('autzen'), '/v1/resample?points=60000'],
    ['office1', public('office1'), '/v1/resample?points=50000'],
);

my $data = tempdir(CLEANUP => 1);
my $log = "$out/waiting.log";
my ($binary) = @ARGV;
my @chosen = grep { wanted("waiting_$_->[0]") } @rows;
exit 0 if !@chosen;
open my $empty, '>', $log or die "$log: $!\n";
close $empty;
my $pid = fork // die "fork: $!";
if ($pid == 0) {
    open STDERR, '>>', $log or die;
    exec $binary, 'serve', '--listen', '127.0.0.1:0', '--data', $data;
}
END { kill 'TERM', $pid if $pid; waitpid $pid, 0 if $pid }
chomp(my $url = `tests/demo/listening.sh $log $pid`);
die "the daemon did not start, see $log\n" if $? != 0;
my $http = HTTP::Tiny->new(timeout => 600, keep_alive => 1);

sub slurp { open my $in, '<:raw', shift or die; local $/; return <$in> }

# One job: what was estimated when, in seconds since it was accepted; how long it took; how often progress fell.
sub follow {
    my ($input, $target) = @_;
    my $made = $http->request('POST', "$url$target", { headers => { prefer => 'respond-async' }, content => slurp($input) });
    my $id = decode_json($made->{content})->{jobID} // die "$target: $made->{content}\n";
    my $from = time;
    my (@told, $fell, $last) = ();
    while (1) {
        my $job = decode_json($http->get("$url/v1/jobs/$id")->{content});
        my $now = time - $from;
        die "$target: $job->{status}: $job->{message}\n" if $job->{status} =~ /failed|dismissed/;
        return { told => \@told, seconds => $now, fell => $fell // 0 } if $job->{status} eq 'successful';
        push @told, [$now, $job->{voronoid}{eta}, $job->{updated}] if !@told || $told[-1][2] ne $job->{updated};
        $fell++ if defined $last && $job->{progress} < $last;
        $last = $job->{progress};
        sleep $every;
    }
}

# The estimate at a moment: it counts from the time of the last change.
sub estimate_at {
    my ($run, $moment) = @_;
    my ($last) = grep { $_->[0] <= $moment } reverse @{ $run->{told} };
    return undef unless $last && defined $last->[1];
    my $left = $last->[1] - ($moment - $last->[0]);
    return $left > 0 ? $left : 0;
}

sub is_right {
    my ($estimate, $left) = @_;
    return 0 unless defined $estimate;
    return abs($estimate - $left) <= 1 || ($estimate <= 2 * $left && $left <= 2 * $estimate);
}

my ($right, $all, $fell, @table) = (0, 0, 0);
for my $row (@chosen) {
    my ($name, $input, $target) = @$row;
    if (my $absent = missing("waiting_$name", $input)) {
        push @table, $absent;
        next;
    }
    for (1 .. runs()) {
        my $run = follow($input, $target);
        my $counts = $run->{seconds} >= $least;
        my @said;
        $fell += $run->{fell};
        for my $share (@shares) {
            my ($left, $estimate) = ((1 - $share) * $run->{seconds}, estimate_at($run, $share * $run->{seconds}));
            my $good = is_right($estimate, $left);
            ($right, $all) = ($right + $good, $all + 1) if $counts;
            push @said, sprintf '%s of %.1f %s', defined $estimate ? sprintf('%.1f', $estimate) : '-', $left, $good ? '✓' : '✗';
        }
        push @table, [$name, $target, sprintf('%.1f', $run->{seconds}) . ($counts ? '' : ' (too short)'), @said];
    }
}
table(['job', 'request', 's', map { 100 * $_ . ' %' } @shares], \@table,
    "Estimate of what was left, s: right within a factor 2 or 1 s. $right of $all are"
    . ($all > 0 ? sprintf(', %.0f %% (asked: 90 %%)', 100 * $right / $all) : '') . ". progress fell $fell times.");
finish('waiting');
