#!/usr/bin/perl
# Mixed traffic: jobs, refusals, streams, lists and callers who leave, for 8 seconds (15 minutes in the long form). Memory and files
# once all is quiet, against those after the warm-up.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Getopt::Long;
use Processes;
use Time::HiRes qw(time sleep);
use Vt;

my ($long, $seed) = (0, 1);
GetOptions('long' => \$long, 'seed=i' => \$seed) or exit 2;
$| = 1;
srand $seed;
my ($warm, $whole) = $long ? (300, 900) : (2.5, 7);

sub row { my ($what, $figure, $wanted, $holds) = @_; print join("\t", 'G25', $what, $figure, $wanted, $holds ? 'ok' : 'short'), "\n" }

my $daemon = Vt->start('result-ttl' => 5);
my @clouds = map { sphere_ply($_) } 300, 1000, 3000;
my $broken = substr $clouds[2], 0, 2000;
my ($count, @wrong) = (0);

sub expect { my ($what, $got, @want) = @_; $count++; push @wrong, "$what: $got" unless grep { $got == $_ } @want }

my @traffic = (
    sub { expect('call', $daemon->post('/v1/resample?points=100&iterations=3', $clouds[rand @clouds])->{status}, 200) },
    sub { expect('broken', $daemon->post('/v1/resample?points=100', $broken)->{status}, 422) },
    sub { expect('range', $daemon->post('/v1/resample?points=0', $clouds[0])->{status}, 400) },
    sub { expect('list', $daemon->get('/v1/jobs?limit=20')->{status}, 200) },
    sub { expect('nothing', $daemon->get('/v1/jobs/00000000-0000-7000-8000-000000000000')->{status}, 404) },
    sub {
        my $id = $daemon->submit('points=100&iterations=5', $clouds[1]);
        my $stream = $daemon->events("/v1/jobs/$id/events");
        $stream->next_event;
        $stream->close; # it leaves
        $daemon->finish($id);
        expect('result', $daemon->get("/v1/jobs/$id/results/cloud")->{status}, 200);
        expect('delete', $daemon->request('DELETE', "/v1/jobs/$id")->{status}, 200);
    },
    sub { # leaves in the middle of its upload
        my $socket = $daemon->connect;
        $socket->syswrite("POST /v1/resample?points=10 HTTP/1.1\r\nHost: x.localhost\r\nContent-Length: 100000\r\n\r\nply");
        $socket->syswrite("GET / HTTP/1.1\r\n");
    },
    sub { my $socket = $daemon->connect; $socket->syswrite("GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\n") },
);

# Once nothing is under way: bytes in memory of the front, open files, bytes of the worker.
sub quiet {
    sleep 0.7;
    my ($rss) = Vt::slurp("/proc/$daemon->{pid}/smaps_rollup") =~ /^Rss:\s+(\d+)/m;
    return (1024 * $rss, scalar(() = glob "/proc/$daemon->{pid}/fd/*"), resident($daemon, 'vor-worker'));
}

my $began = time;
my @before;
while (time - $began < $whole) {
    $traffic[rand @traffic]->();
    @before = quiet() if !@before && time - $began > $warm;
}
$daemon->{http} = undef;
my @after = quiet();
my $grown = ($after[0] - $before[0]) / 1048576;
row("$count requests in " . int($whole) . ' s: answers that were not the right one', scalar(@wrong), 0, !@wrong);
print STDERR "$_\n" for @wrong;
row('memory of the front at the end, against that after the warm-up', sprintf('%+.1f MiB', $grown), '+4 MiB at most', $grown <= 4);
$grown = ($after[2] - $before[2]) / 1048576;
row('memory of the worker, likewise', sprintf('%+.1f MiB of %.1f', $grown, $after[2] / 1048576), '+4 MiB at most',
    $after[2] > 0 && $grown <= 4);
row('open files, likewise', sprintf('%+d', $after[1] - $before[1]), '+2 at most', $after[1] - $before[1] <= 2);
row('exit status', $daemon->stop, 0, 1);
my $loud = grep { ($_->{level} // '') =~ /warn|error/ } $daemon->log_lines;
row('warnings and errors in the log', $loud, 0, $loud == 0);
