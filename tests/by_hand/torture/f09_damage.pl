#!/usr/bin/perl
# A table of jobs that is gone: no result is swept away. One flipped bit in an input, in a result: no wrong byte goes out.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Faults;
use Vt;

my %option = options();
srand $option{seed};
my $cloud = sphere_ply(6000); # no small file

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

my $runs = $option{long} ? 20 : 2;
my ($lost, $swept, $warned) = (0, 0, 0);
for my $run (1 .. $runs) {
    my $daemon = Vt->start;
    my @ids = map { $daemon->submit('points=6000&iterations=2', $cloud) } 1 .. 12;
    $daemon->finish($_) for @ids;
    $daemon->stop('KILL');
    unlink glob "$daemon->{dir}/data/jobs.sqlite*";
    my $again = Vt->start(dir => $daemon->{dir}, jobs => 1);
    $warned += wait_until(sub { grep { $_->{msg} =~ /ARE MISSING FROM/ } $again->log_lines }, 5) ? @ids : 0;
    for my $id (@ids) {
        $lost++ if $again->get("/v1/jobs/$id/results/cloud")->{status} != 200;
        $swept++ unless -e "$daemon->{dir}/data/blobs/keep/$id.cloud" || -e "$daemon->{dir}/data/blobs/keep/$id.cloud-1";
    }
    $again->stop;
}
figure('F09', "results without a row, of " . 12 * $runs . ' jobs, the table gone', $lost, 12 * $runs);
figure('F09', 'of these swept away', $swept, 0);
figure('F09', 'of these in a warning with number and bytes', $warned, $lost);

my $daemon = Vt->start(jobs => 1);
my $done = $daemon->submit('points=6000&iterations=2', $cloud);
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
