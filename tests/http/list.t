#!/usr/bin/perl
# A list of more jobs than are written at a step: whole, in order, and in pages of any size.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $jobs = 203; # four steps and some
my $daemon = Vt->start(jobs => 1);
my $cloud = sphere_ply(60);
my @ids = ($daemon->submit('points=900&iterations=10000&polish=10000&delta=0&moveStop=0', sphere_ply(3000)));
push @ids, $daemon->submit("points=20&iterations=1&polish=0&seed=$_", $cloud) for 2 .. $jobs;
my @newest = reverse @ids;

# The identifiers of a page, and the path of the next one or undef. Perl takes 10 ms to read a job as JSON.
sub page {
    my ($path) = @_;
    my $text = $daemon->get($path)->{content};
    my ($next) = $text =~ /"rel":"next","type":"[^"]*","href":"\Q$daemon->{url}\E([^"]*)"/;
    return ([$text =~ /"jobID":"([^"]*)"/g], $next);
}

for my $limit (1000, $jobs, $jobs - 1, 200, 100, 99) {
    my ($path, @sizes, @all) = ("/v1/jobs?limit=$limit");
    while (defined $path) {
        (my $page, $path) = page($path);
        push @sizes, scalar @$page;
        push @all, @$page;
    }
    my $full = int(($jobs - 1) / $limit);
    is_deeply \@sizes, [($limit) x $full, $jobs - $full * $limit], "pages of $limit are full but for the last";
    is_deeply \@all, \@newest, 'and have every job once, the newest first';
}
my ($page) = page('/v1/jobs?limit=1000&status=running');
is_deeply $page, [$ids[0]], 'a list of few of them is whole as well';

# Callers who leave in the middle of one.
for (1 .. 20) {
    my $socket = $daemon->connect;
    $socket->syswrite("GET /v1/jobs?limit=1000 HTTP/1.1\r\nHost: localhost\r\n\r\n");
    $socket->close;
}
is $daemon->get('/livez')->{status}, 200, 'callers who leave harm nobody';
$daemon->request('DELETE', "/v1/jobs/$ids[0]");
is $daemon->stop, 0, 'it ends with 0';
done_testing;
