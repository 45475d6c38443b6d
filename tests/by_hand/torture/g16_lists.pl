#!/usr/bin/perl
# Clients who ask for lists of all jobs there are, again and again: how long /livez waits beside them.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use List::Util qw(max);
use Time::HiRes qw(sleep time);
use Sockets;
use Vt;

my ($long, $seed) = Sockets::options();
my $jobs = $long ? 10_000 : 600;
my $seconds = $long ? 20 : 2;
my $daemon = Vt->start(jobs => 1, queue => 20_000);
$daemon->submit('points=900&iterations=10000&polish=10000&delta=0&moveStop=0', sphere_ply(3000));
my $cloud = sphere_ply(60);
$daemon->submit('points=20&iterations=1&polish=0', $cloud) for 2 .. $jobs;

my $until = time + $seconds;
my @listing = map {
    Sockets::beside(sub {
        my ($out) = @_;
        while (time < $until) {
            my $text = $daemon->get('/v1/jobs?limit=10000')->{content};
            print $out scalar(() = $text =~ /"jobID"/g), "\n";
        }
    })
} 1 .. 4;
my ($missed, @took) = (0);
while (time < $until) {
    my ($took, $code) = Sockets::timed($daemon, "GET /livez HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n", 10);
    push @took, $took;
    $missed++ if $code != 200;
    sleep 0.02;
}
my @lists = map { Sockets::take_lines($_) } @listing;
my $load = Sockets::load();
Sockets::row('G16', "/livez beside four clients that list $jobs jobs, load $load: missed of " . @took, $missed, 0, $missed == 0);
Sockets::row('G16', '/livez beside the lists, p99', sprintf('%.1f ms', 1000 * Sockets::percentile(0.99, @took)), '<= 100 ms',
    Sockets::percentile(0.99, @took) <= 0.1);
Sockets::row('G16', 'lists that lack jobs, of ' . @lists, scalar(grep { $_ != $jobs } @lists), 0, @lists > 0 && !grep { $_ != $jobs } @lists);
$daemon->stop('KILL');
