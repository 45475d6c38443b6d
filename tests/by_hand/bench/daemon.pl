#!/usr/bin/perl
# usage: daemon.pl VORONOID OUTDIR: what a caller waits for: DELETE of a running job of a million points, and how much the
# daemon's memory grows while 200 MB come in. Writes OUTDIR/daemon.md.
use strict;
use warnings;
use lib 'tests/support';
use Fcntl qw(SEEK_SET);
use File::Temp qw(tempdir);
use HTTP::Tiny;
use IO::Socket::INET;
use JSON::PP;
use Time::HiRes qw(sleep time);

my ($binary, $out) = @ARGV;
my $runs = $ENV{RUNS} // 5;
my $data = tempdir(CLEANUP => 1);
my $log = "$out/daemon.log";
my $pid = fork // die "fork: $!";
if ($pid == 0) {
    open STDERR, '>', $log or die;
    exec $binary, 'serve', '--listen', '127.0.0.1:0', '--data', $data;
}
END { kill 'TERM', $pid if $pid; waitpid $pid, 0 if $pid }

my $address;
for (1 .. 100) {
    sleep 0.1;
    open my $in, '<', $log or next;
    local $/;
    ($address) = <$in> =~ /"address":"([^"]+)"/ and last;
}
die "the daemon did not start, see $log\n" unless $address;
my $http = HTTP::Tiny->new(timeout => 600);

# A binary PLY of n random points on a sphere.
sub cloud {
    my ($path, $n) = @_;
    open my $ply, '>:raw', $path or die "$path: $!";
    print $ply "ply\nformat binary_little_endian 1.0\nelement vertex $n\n",
        "property float x\nproperty float y\nproperty float z\nend_header\n";
    srand 7;
    for (1 .. $n) {
        my ($z, $a) = (2 * rand() - 1, 6.283185307 * rand());
        my $r = sqrt(1 - $z * $z);
        print $ply pack 'f<3', $r * cos $a, $r * sin $a, $z;
    }
    close $ply;
}

sub slurp { open my $in, '<:raw', shift or die; local $/; return <$in> }

sub high_water {
    my ($kb) = slurp("/proc/$pid/status") =~ /^VmHWM:\s+(\d+)/m;
    return $kb / 1024;
}

sub busy {
    my @field = split ' ', slurp("/proc/$pid/stat");
    return ($field[13] + $field[14]) / 100;
}

# Sends 200 MB that are no cloud, so that nothing is decoded, and sees how far the memory's high-water mark moved.
sub upload_growth {
    my $before = high_water();
    my $piece = "\0" x 1_000_000;
    my $left = 200;
    my $answer = $http->request('POST', "http://$address/v1/resample?points=10", {
        headers => { 'content-length' => 200_000_000 },
        content => sub { return $left-- > 0 ? $piece : '' },
    });
    die "the upload got $answer->{status}\n" unless $answer->{status} == 415;
    return high_water() - $before;
}

# Milliseconds until DELETE of a running job answers `dismissed`, and until the cores are free.
sub cancel_times {
    my ($body) = @_;
    my $made = $http->request('POST', "http://$address/v1/resample?ratio=1&iterations=100",
        { headers => { prefer => 'respond-async' }, content => $body });
    my $job = decode_json($made->{content})->{jobID} // die $made->{content};
    my $url = "http://$address/v1/jobs/$job";
    sleep 0.2 while decode_json($http->get($url)->{content})->{status} eq 'accepted';
    sleep 1 + 4 * rand();
    my $from = time;
    my $status = decode_json($http->request('DELETE', $url)->{content})->{status};
    my $answered = time - $from;
    die "DELETE says $status\n" unless $status eq 'dismissed';
    my $freed;
    for (1 .. 200) {
        my $used = busy();
        sleep 0.1;
        if (busy() - $used < 0.02) { $freed = time - $from - 0.1; last }
    }
    return (1000 * $answered, 1000 * ($freed // 1e9));
}

sub summary {
    my @sorted = sort { $a <=> $b } @_;
    return sprintf '%.0f (%.0f to %.0f)', $sorted[$#sorted / 2], $sorted[0], $sorted[-1];
}

my $growth = upload_growth();
cloud("$data/million.ply", 1_000_000);
my $body = slurp("$data/million.ply");
my (@answered, @freed);
for (1 .. $runs) {
    my ($answer, $free) = cancel_times($body);
    push @answered, $answer;
    push @freed, $free;
}
open my $table, '>', "$out/daemon.md" or die;
print $table "\n# Daemon\n\n| what | measured | asked |\n|---|---|---|\n";
printf $table "| DELETE of a running job, 1 M points, answers dismissed, ms, median (range) of %d | %s | <= 200 |\n", $runs, summary(@answered);
printf $table "| the cores are free, ms | %s | <= 1000 |\n", summary(@freed);
printf $table "| VmHWM over a 200 MB upload, MB | %.1f | <= 16 |\n", $growth;
close $table;
