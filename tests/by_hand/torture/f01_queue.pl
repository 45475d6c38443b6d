#!/usr/bin/perl
# What a small body decodes to is charged before its job is accepted: to the queue, and to the disk.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Faults;
use Vt;

our @arguments;
BEGIN { @arguments = @ARGV }
my %option = options();
my $disk = small_disk(64 * 1024) // do { print STDERR "f01: no mount namespace here\n"; exit 1 };
my $bound = 4 << 20;
my $reserve = 8 << 20;
my $daemon = Vt->start(data => "$disk/data", 'disk-reserve' => $reserve, jobs => 1, 'queue-bytes' => $bound, 'keep-inputs' => 0);
my $decoded = 12 * 50_000;
my $cloud = sphere_ply(50_000);
$daemon->submit('points=2000&iterations=10000&polish=0', sphere_ply(3000));
my %answers;
my $retry = '';
for (1 .. 20) {
    my $answer = $daemon->post('/v1/resample?points=100', $cloud, Prefer => 'respond-async');
    $answers{ $answer->{status} }++;
    $retry = $answer->{headers}{'retry-after'} // 'none' if $answer->{status} == 429;
}
my $kept = 0;
$kept += -s $_ for glob "$disk/data/blobs/keep/*.input";
figure('F01', 'answers to 20 clouds of 600 KB', join(' ', map { "$_: $answers{$_}" } sort keys %answers), '201: 6 429: 14');
figure('F01', 'Retry-After of a refusal', "$retry s", 'whole seconds', $retry =~ /^\d+$/);
figure('F01', 'bytes of decoded inputs on the disk', $kept, "at most $bound, and the running one's",
    $kept <= $bound + 12 * 3000 + 1000);
my $large = $daemon->post('/v1/resample?points=100', sphere_ply(400_000), Prefer => 'respond-async');
figure('F01', 'an input beyond --queue-bytes alone', $large->{status}, 413);

# A disk with no room for the decoded bytes beside the reserve.
$daemon->stop;
fill($disk, $reserve + length($cloud) + $decoded / 2);
my $tight = Vt->start(data => "$disk/data", 'disk-reserve' => $reserve, 'keep-inputs' => 0);
my $answer = $tight->post('/v1/resample?points=100', $cloud, Prefer => 'respond-async');
figure('F01', 'an upload that fits, and decoded does not', "$answer->{status}, Retry-After " . ($answer->{headers}{'retry-after'} // 'none'),
    '507 with Retry-After', $answer->{status} == 507 && $answer->{headers}{'retry-after'});
$tight->stop;
