#!/usr/bin/perl
# A queue that is asked for ten times what it holds, then drained.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Jobs;
use Time::HiRes qw(time);
use Vt;

my $capacity = $long ? 64 : 20;
my $cloud = sphere_ply(200);
my $daemon = Vt->start(jobs => 1, queue => $capacity);
my ($blocker) = async($daemon, 'resample?points=200&iterations=10000&polish=0', sphere_ply(3000));
my (@accepted, @took, @odd);
for (1 .. 10 * $capacity) {
    my ($answer, $seconds) = async($daemon, 'resample?points=20&iterations=1&polish=0', $cloud);
    if ($answer->{status} == 201) {
        push @accepted, json($answer)->{jobID};
        next;
    }
    push @took, $seconds;
    push @odd, "$answer->{status} " . ($answer->{headers}{'retry-after'} // 'without Retry-After')
        unless $answer->{status} =~ /^(429|503)$/ && ($answer->{headers}{'retry-after'} // '') =~ /^\d+$/;
}
figure('G16', 'refusals that are no 429 or 503 with whole Retry-After, of ' . @took, scalar(@odd), '0', !@odd);
my $late = 1000 * percentile(0.99, @took);
figure('G16', 'refused within, p99', sprintf('%.1f ms', $late), '<= 10 ms', $late <= 10);
$daemon->request('DELETE', '/v1/jobs/' . json($blocker)->{jobID});
my @over = map { $daemon->finish($_) } @accepted;
my $good = grep { $_->{status} eq 'successful' } @over;
figure('G16', 'accepted jobs that finish', "$good of " . @accepted, 'all', $good == @accepted);
my @wrong = grep { $over[$_]{started} lt $over[$_ - 1]{started} } 1 .. $#over;
figure('G16', 'jobs that start before an earlier one', scalar(@wrong), '0', !@wrong);
$daemon->stop;
