#!/usr/bin/perl
# A start with many jobs that wait.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Jobs;
use Sockets ();
use Time::HiRes qw(time);
use Vt;

my $jobs = $long ? 10_000 : 150;
my $cloud = sphere_ply(60);
my $daemon = Vt->start(jobs => 1, queue => 20_000);
async($daemon, 'resample?points=900&iterations=10000&polish=0', sphere_ply(3000));
my $accepted = 0;
for (1 .. $jobs) {
    my ($answer) = async($daemon, 'resample?points=20&iterations=1&polish=0', $cloud);
    $accepted++ if $answer->{status} == 201;
}
kill 'KILL', $daemon->{pid};
Vt::reap(delete $daemon->{pid});
my (@took, @computed);
for (1 .. 3) {
    my $began = time;
    my $next = Vt->start(dir => $daemon->{dir}, jobs => 1, queue => 20_000);
    push @took, time - $began;
    push @computed, Sockets::cpu_seconds($next);
    $next->stop('KILL');
}
my $each = percentile(0.5, @took);
figure('F13', "ready after kill -9 with $accepted waiting jobs", sprintf('%.2f s', $each), '<= 1 s (was 1.6 with 10,000)', $each <= 1);
$each = percentile(0.5, @computed);
figure('F13', 'the time that it computes', sprintf('%.2f s', $each), '<= 1 s', $each <= 1);
