#!/usr/bin/perl
# How long a job may run: the limits of the daemon and of the request, and what is refused before it runs.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Jobs;
use Time::HiRes qw(time);
use Vt;

my $cloud = sphere_ply(1000);
my $extreme = 'resample?points=16000&neighbors=500&iterations=10000&polish=10000';
my $daemon = Vt->start(jobs => 2);
my ($answer, $seconds) = async($daemon, $extreme, $cloud);
my $problem = json($answer);
figure('F6', '12 KB with extreme parameters: status', sprintf('%d after %.3f s, estimate %.0f s', $answer->{status}, $seconds, $problem->{got}),
    '422 naming estimate and limit (was accepted)', $answer->{status} == 422 && $problem->{got} > $problem->{limit});

my $began = time;
($answer) = async($daemon, "$extreme&seconds=1", $cloud);
my $how = outcome($daemon, json($answer)->{jobID});
my $took = time - $began;
figure('F6', 'the same with seconds=1 ends after', sprintf('%.1f s, %s', $took, $how), '<= 2 s (was 44)', $took <= 2 && $how eq 'successful');
($answer) = async($daemon, 'resample?points=2000&iterations=10000&polish=10000&seconds=1', $cloud);
$began = time;
outcome($daemon, json($answer)->{jobID});
$took = time - $began;
figure('F6', '2000 points with usual neighbors and seconds=1 end after', sprintf('%.2f s', $took), '<= 1.5 s', $took <= 1.5);
my $wide = sphere_ply(20_000);
my $many = 'iterations=10000&polish=10000&seconds=1';
for (["20,000 points with 500 neighbors", "resample?points=20000&neighbors=500&$many", $wide],
    ['16,000 on 1,000 with 500 neighbors by metric lp', "resample?points=16000&neighbors=500&metric=lp&$many", $cloud],
    ['100,000 on 20,000 in progressive order', "resample?points=100000&order=progressive&$many", $wide]) {
    my ($what, $request, $body) = @$_;
    ($answer) = async($daemon, $request, $body);
    $began = time;
    $how = outcome($daemon, json($answer)->{jobID});
    $took = time - $began;
    figure('F6', "$what and seconds=1 end after", sprintf('%.1f s, %s', $took, $how), '<= 2 s', $took <= 2 && $how eq 'successful');
}
$daemon->stop;

my $limit = $long ? 10 : 1.5;
$daemon = Vt->start('job-seconds' => $limit);
$began = time;
($answer) = async($daemon, 'resample?points=' . 1000 * $limit . '&iterations=' . ($long ? 3000 : 2000) . '&polish=0', $cloud);
$how = $answer->{status} == 201 ? outcome($daemon, json($answer)->{jobID}) : $answer->{content};
$took = time - $began - $limit;
figure('G3', "a job that runs longer than $limit s ends later by", sprintf('%.2f s, %s', $took, $how), '<= 1 s',
    $took <= 1 && $how =~ /as long as it may/);
$daemon->stop;
