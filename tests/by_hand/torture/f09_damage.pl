#!/usr/bin/perl
# One flipped bit: in the log of the table of jobs, in an input, in a result. Nothing is swept away, and no wrong byte goes
# out.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Faults;
use Vt;

my %option = options();
srand $option{seed};
my $cloud = sphere_ply(1000);

# Flips a bit of a file, at a share of its length.
sub flip {
    my ($path, $share) = @_;
    my $size = -s $path // die "$path: $!";
    my $at = int($share * $size);
    open my $file, '+<:raw', $path or die "$path: $!";
    seek $file, $at, 0;
    read $file, my $byte, 1;
    seek $file, $at, 0;
    print $file chr(ord($byte) ^ 1 << int rand 8);
    close $file;
}

my $runs = $option{long} ? 100 : 5;
my ($lost, $swept, $warned) = (0, 0, 0);
for my $run (1 .. $runs) {
    my $daemon = Vt->start;
    my @ids = map { $daemon->submit('points=50&iterations=2', $cloud) } 1 .. 6;
    $daemon->finish($_) for @ids;
    $daemon->stop('KILL');
    flip("$daemon->{dir}/data/jobs.sqlite-wal", 0.02 + 0.96 * rand);
    my $again = Vt->start(dir => $daemon->{dir}, jobs => 1);
    my ($line) = wait_until(sub { grep { $_->{msg} =~ /ARE MISSING FROM|^strays/ } $again->log_lines }, 1) ?
        grep { $_->{msg} =~ /ARE MISSING FROM/ } $again->log_lines : ();
    for my $id (@ids) {
        my $got = $again->get("/v1/jobs/$id/results/cloud")->{status};
        next if $got == 200;
        $lost++;
        $swept++ unless grep { -e "$daemon->{dir}/data/blobs/$_/$id.cloud" } 'lost', 'keep';
        $warned += $line ? 1 : 0;
    }
    $again->stop;
}
figure('F09', "results without a row, of " . 6 * $runs . ' jobs, a bit of the log flipped', $lost, 'any', 1);
figure('F09', 'of these swept away', $swept, 0);
figure('F09', 'of these in a warning with number and bytes', $warned, $lost);

my $daemon = Vt->start(jobs => 1);
my $done = $daemon->submit('points=400&iterations=2', $cloud);
$daemon->finish($done);
my $bytes = $daemon->get("/v1/jobs/$done/results/cloud")->{content};
$daemon->stop;
flip("$daemon->{dir}/data/blobs/keep/$done.cloud", rand);
flip("$daemon->{dir}/data/blobs/keep/$done.upload", rand);
my $again = Vt->start(dir => $daemon->{dir}, jobs => 1);
for my $what ('results/cloud', 'input', 'results/cloud?format=drc') {
    my $got = $again->get("/v1/jobs/$done/$what");
    figure('F09', "GET $what with a bit flipped", "$got->{status} " . (eval { json($got)->{type} } // 'bytes') =~ s{.*/}{}r,
        '500 damaged-bytes');
}
my $part = $again->get("/v1/jobs/$done/results/cloud", headers => { Range => 'bytes=0-9' });
figure('F09', 'a range of it', $part->{status}, 500);

# A job whose input is damaged while it waits.
my $blocker = $again->submit('points=800&iterations=10000&polish=0', $cloud);
my $waits = $again->submit('points=100&iterations=1', $cloud);
flip("$daemon->{dir}/data/blobs/keep/$waits.input", rand);
$again->request('DELETE', "/v1/jobs/$blocker");
my $end = $again->finish($waits);
figure('F09', 'a job whose input has a bit flipped', "$end->{status} " . ($end->{exception}{type} // '') =~ s{.*/}{}r,
    'failed damaged-bytes', $end->{status} eq 'failed');
$again->stop;
