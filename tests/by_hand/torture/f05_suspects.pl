#!/usr/bin/perl
# Who is blamed for a crash: a poison among good jobs, and kill -9 while jobs run. The poison is a process of the binary of
# tests/poison.
use strict;
use warnings;
use FindBin;
BEGIN { $ENV{VORONOID} = 'build/release/tests/poison/voronoid' }
use lib $FindBin::Bin;
use Jobs;
use Time::HiRes qw(sleep);
use Vt;

-x $ENV{VORONOID} or die "there is no $ENV{VORONOID}: make $ENV{VORONOID}\n";
my $cloud = sphere_ply(300);
my $probes = my $missed = 0;

sub again {
    my ($before) = @_;
    Vt::reap(delete $before->{pid}) if $before->{pid};
    for (1 .. 5) {
        my $next = eval { Vt->start(dir => $before->{dir}, jobs => 4, queue => 5000) };
        return $next if $next;
    }
    die "it does not start\n";
}

sub submit {
    my ($daemon, $path) = @_;
    my ($answer) = eval { async($daemon, $path, $cloud) };
    return $answer && $answer->{status} == 201 ? json($answer)->{jobID} : undef;
}

my $rounds = $long ? 20 : 2;
my ($good_over, $good, $poison_failed, $crashes, $ends) = (0, 0, 0, 0, 0);
for my $round (1 .. $rounds) {
    my $daemon = Vt->start(jobs => 4);
    my @good = map { submit($daemon, 'resample?points=100&iterations=30') } 1 .. 20;
    my $poison = submit($daemon, $round % 2 ? 'fault' : 'abort');
    @good = grep {defined} @good;
    my $info;
    while (1) {
        $info = eval { json($daemon->get("/v1/jobs/$poison")) };
        last if $info && $info->{status} eq 'failed';
        if (!$info) {
            $ends++;
            $daemon = again($daemon);
        }
        sleep 0.02;
    }
    $poison_failed++;
    $crashes += grep { $_->{msg} eq 'run lost' && $_->{job} eq $poison } $daemon->log_lines;
    $good += @good;
    $good_over += grep { outcome($daemon, $_) eq 'successful' } @good;
    $daemon->stop;
}
figure('G3', "good jobs beside a poison that succeed, $rounds times 20", "$good_over of $good", 'all', $good_over == $good);
figure('G3', 'poisons that fail', "$poison_failed of $rounds", 'all', $poison_failed == $rounds);
figure('G3', 'crashes of workers until a poison fails, the one beside others included', sprintf('%.1f', $crashes / $rounds), '1 to 3',
    $crashes >= $rounds && $crashes <= 3 * $rounds);
figure('G3', 'ends of the daemon meanwhile', $ends, 0, $ends == 0);

my $kills = $long ? 150 : 12;
my $daemon = Vt->start(jobs => 4, queue => 5000);
my @jobs;
for (1 .. $kills) {
    push @jobs, grep {defined} map { submit($daemon, 'resample?points=100&polish=0&iterations=' . int(1 + rand 200)) } 1 .. 6;
    sleep 0.05 + rand 0.15;
    kill 'KILL', $daemon->{pid};
    $daemon = again($daemon);
}
my @failed = grep { $_ ne 'successful' } map { outcome($daemon, $_) } @jobs;
figure('F5', "jobs of " . @jobs . " that fail under $kills kill -9 while they run", scalar(@failed), '0 (was 65 of 2700)', !@failed);
$daemon->stop;
