#!/usr/bin/perl
# A full disk: what may be ended and removed all the same, who waits, and that everything goes on once there is room.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Faults;
use Vt;

our @arguments;
BEGIN { @arguments = @ARGV }
my %option = options();
my $disk = small_disk(24 * 1024) // do { print STDERR "f07: no mount namespace here\n"; exit 1 };
my @settings = (data => "$disk/data", 'disk-reserve' => '4M', jobs => 1, 'keep-inputs' => 0);
my $daemon = Vt->start(@settings);
my $cloud = sphere_ply(2000);
my $done = $daemon->submit('points=200&iterations=2', $cloud);
$daemon->finish($done);

# A job that is stopped on a full disk has bytes to keep and no room for them.
my $runs = $daemon->submit('points=20000&iterations=3000&polish=0', $cloud);
wait_until(sub { (json($daemon->get("/v1/jobs/$runs"))->{voronoid}{metrics}{iteration} // -1) >= 0 }, 20);
fill($disk);
figure('F07', '/readyz while the disk is full', $daemon->get('/readyz')->{status}, 503);
$daemon->request('POST', "/v1/jobs/$runs/stop", content => '');
wait_until(sub { $daemon->log_text =~ /waits for room/ }, 20);
my $refused = $daemon->post('/v1/resample?points=5', $cloud, Prefer => 'respond-async');
figure('F07', 'a submit on a full disk', "$refused->{status}, Retry-After " . ($refused->{headers}{'retry-after'} // 'none'),
    '507 with Retry-After', $refused->{status} == 507 && $refused->{headers}{'retry-after'});
fill($disk);
figure('F07', 'DELETE of a finished job on a full disk', $daemon->request('DELETE', "/v1/jobs/$done")->{status}, 200);
fill($disk);
figure('F07', 'the job whose result does not fit', $daemon->status($runs), 'running');

# A start with a job to recover, on a disk without a byte left but the reserve, which was made again meanwhile.
truncate "$disk/filler", (-s "$disk/filler") - (9 << 20);
wait_until(sub { -s "$disk/data/jobs.sqlite.reserve" }, 10) or die 'the reserve does not come back';
$daemon->stop('KILL');
fill($disk);
my $again = eval { Vt->start(@settings) };
figure('F07', 'a start with a job to recover on a full disk', $again ? 'listens' : substr($@, 0, 80), 'listens', $again);
exit 0 unless $again;

# The same once more, with nothing left of the reserve but what is kept for a start.
$again->stop('KILL');
truncate "$disk/data/jobs.sqlite.reserve", 256 << 10;
fill($disk);
$again = eval { Vt->start(@settings) };
figure('F07', 'a start on a full disk whose reserve is spent', $again ? 'listens, /readyz ' . $again->get('/readyz')->{status} : substr($@, 0, 80),
    'listens, /readyz 503', $again && $again->get('/readyz')->{status} == 503);
exit 0 unless $again;
unlink "$disk/filler";
my $back = wait_until(sub { $again->get('/readyz')->{status} == 200 }, 10);
figure('F07', '/readyz once there is room', $back ? 200 : 503, 200, $back);
$again->request('POST', "/v1/jobs/$runs/stop", content => '')
    if wait_until(sub { (json($again->get("/v1/jobs/$runs"))->{voronoid}{metrics}{iteration} // -1) >= 0 }, 20);
my $end = $again->finish($runs);
figure('F07', 'the job once there is room', $end->{status}, 'successful', $end->{status} eq 'successful');
my $bytes = $again->get("/v1/jobs/$runs/results/cloud")->{content};
figure('F07', 'its result', ($bytes =~ /^element vertex (\d+)$/m)[0] . ' points', '20000 points', $bytes =~ /^element vertex 20000$/m);
figure('F07', 'exit status at the end', $again->stop, 0);
