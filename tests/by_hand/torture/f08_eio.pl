#!/usr/bin/perl
# A disk whose fsync fails: the daemon ends by itself, says so once, and its next start has every job that was accepted.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Time::HiRes qw(time);
use Faults;
use Vt;

my %option = options();
my $cloud = sphere_ply(6000); # no small file
for my $call ('fdatasync', 'fsync') { # rows, bytes
    my $daemon = Vt->start;
    my $done = $daemon->submit('points=50&iterations=2', $cloud);
    $daemon->finish($done);
    my $runs = $daemon->submit('points=800&iterations=10000&polish=0', $cloud);
    inject($daemon, "$call:error=EIO") // do { print STDERR "f08: no strace here\n"; exit 1 };
    my $began = time;
    my $answer = eval { $daemon->post('/v1/resample?points=5', $cloud, Prefer => 'respond-async')->{status} } // 'cut';
    figure('F08', "a submit while $call fails", $answer, '503, or cut', $answer =~ /^(?:503|cut)$/);
    my $exit = Vt::reap(delete $daemon->{pid});
    figure('F08', "exit status after $call fails", $exit, 'not 0', $exit =~ /^[1-9]\d*$/);
    figure('F08', 'time until it has ended', sprintf('%.1f s', time - $began), '5 s at most', time - $began <= 5);
    my @lines = grep { $_->{msg} =~ /a disk failed/ } $daemon->log_lines;
    figure('F08', 'lines of the log that say so', scalar(@lines), 1);
    my $again = Vt->start(dir => $daemon->{dir});
    my @states = map { $again->status($_) } $done, $runs;
    figure('F08', 'the jobs after the next start', "@states", 'successful, and accepted or running',
        "@states" =~ /^successful (?:accepted|running)$/);
    $again->request('DELETE', "/v1/jobs/$runs");
    figure('F08', 'exit status of that one', $again->stop, 0);
}
