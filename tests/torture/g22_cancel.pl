#!/usr/bin/perl
# DELETE at random moments of a run: how soon the job says dismissed, and how soon its place is free.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Jobs;
use Time::HiRes qw(time sleep);
use Vt;

my $times = $long ? 50 : 6;
my $cloud = sphere_ply($long ? 1_000_000 : 100_000);
my $small = sphere_ply(100);
my $daemon = Vt->start(jobs => 1);
my (@said, @free, @shown);
for (1 .. $times) {
    my ($answer) = async($daemon, 'resample?points=20000&normals=oriented', $cloud);
    my $id = json($answer)->{jobID};
    sleep rand($long ? 6 : 0.8);
    my $began = time;
    $daemon->request('DELETE', "/v1/jobs/$id");
    push @said, time - $began;
    my ($next) = async($daemon, 'resample?points=20&iterations=1&polish=0', $small);
    $daemon->finish(json($next)->{jobID});
    push @free, time - $began;
    push @shown, $id if $daemon->get("/v1/jobs/$id/results/cloud")->{status} == 200;
}
my $said = 1000 * percentile(0.99, @said);
figure('G22', "dismissed within, p99 of $times", sprintf('%.0f ms', $said), '<= 200 ms', $said <= 200);
my $free = percentile(0.99, @free);
figure('G22', 'the next small job is over within, p99', sprintf('%.2f s', $free), '<= 2 s', $free <= 2);
figure('G22', 'results of dismissed jobs that can be seen', scalar(@shown), '0', !@shown);
my $threads = () = glob "/proc/$daemon->{pid}/task/*";
my $files = () = glob "/proc/$daemon->{pid}/fd/*";
figure('G22', 'threads and descriptors at the end', "$threads and $files", '<= 20 and 30', $threads <= 20 && $files <= 30);
$daemon->stop;
