#!/usr/bin/perl
# Memory: what jobs are let in with beside what they take, and three times the budget in valid jobs.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Jobs;
use List::Util ();
use Processes;
use Vt;

my $points = $long ? 100_000 : 8_000;
my $cloud = sphere_ply($points);
my $daemon = Vt->start(jobs => 1, memory => 1, 'job-memory' => '4G');
my @requests = map {"resample?iterations=1&polish=1&$_"} 'points=' . $points, 'points=' . 2 * $points, 'points=' . int($points / 4),
    "points=$points&neighbors=60", "points=$points&method=kmeans", "points=$points&density=curvature",
    "points=$points&metric=anisotropic", "points=$points&method=wlop&steps=1", 'points=' . 4 * $points . '&method=ear&steps=1';
my @needs;
for my $request (@requests) {    # one byte is too little for any: the refusal tells the estimate
    my ($answer) = async($daemon, $request, $cloud);
    push @needs, json($answer)->{got} if $answer->{status} == 413;
}
figure('G12', 'requests larger than all memory that are refused with both numbers', @needs . ' of ' . @requests, 'all', @needs == @requests);
$daemon->stop;

$daemon = Vt->start(jobs => 1);
my @ratio;
for my $i (0 .. $#requests) {
    my ($answer) = async($daemon, $requests[$i], $cloud);
    my $id = json($answer)->{jobID};
    outcome($daemon, $id);
    my $peak = json($daemon->get("/v1/jobs/$id/results/report"))->{memory_peak_bytes};
    push @ratio, $needs[$i] / $peak;
}
@ratio = sort { $a <=> $b } @ratio;
figure('G12', 'estimate over peak of ' . @ratio . ' requests', sprintf('%.2f to %.2f', @ratio[0, -1]), '0.8 to 1.5',
    $ratio[0] >= 0.8 && $ratio[-1] <= 1.5);
$daemon->stop;

my $budget = int($needs[0] * 2.2);
$daemon = Vt->start(jobs => 16, memory => $budget, 'job-memory' => $budget);
my @ids = map { my ($answer) = async($daemon, $requests[0], $cloud); json($answer)->{jobID} } 1 .. ($long ? 30 : 7);
my %how;
$how{ outcome($daemon, $_) }++ for @ids;
figure('F11', 'jobs that fit alone and not together, of ' . @ids . ' at once: that ended well', $how{successful} // 0,
    'all (was: two ended each other)', ($how{successful} // 0) == @ids);
my %peak = map { ($_->[0] => peak($daemon, $_->[0])) } family($daemon);
my $worker = $peak{'vor-worker'} // 0;
my $all = List::Util::sum(values %peak);
figure('G12', 'peak of the worker meanwhile over the budget', sprintf('%.2f', $worker / $budget), 'above 0; <= 1.2 beyond 64 MB',
    $worker > 0 && $worker <= 1.2 * $budget + (64 << 20));
figure('G12', 'peaks of ' . join(', ', sort keys %peak) . ' together over the budget', sprintf('%.2f', $all / $budget), '<= 1.2 beyond 64 MB',
    $all <= 1.2 * $budget + (64 << 20));
$daemon->stop;
