#!/usr/bin/perl
# The same bytes for any number of threads, on every run, without the processor's newer instructions, and after a kill -9
# in the middle of the job.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Faults;
use Vt;

my %option = options();
my $dir = tempdir(CLEANUP => 1);
my $n = $option{long} ? 50_000 : 4_000;
my $cloud = sphere_ply($n);
my $query = 'points=' . $n / 4 . '&iterations=40&seed=' . $option{seed};

open my $out, '>:raw', "$dir/in.ply" or die $!;
print {$out} $cloud;
close $out or die $!;

# SHA-256 of what the command line makes of it with so many threads.
sub here {
    my ($threads) = @_;
    my @options = map { my ($name, $value) = split /=/; ("--$name", $value) } split /&/, $query;
    system($ENV{VORONOID}, 'resample', "$dir/in.ply", @options, '--threads', $threads, '--quiet', '-f', '-o', "$dir/out.ply") == 0
        or die "a run at $threads threads\n";
    return sha256_hex(Vt::slurp("$dir/out.ply"));
}

my @threads = (1, 2, 4, 8);
my $runs = $option{long} ? 20 : 3;
my %seen = map { $_ => 1 } map { my $threads = $_; map { here($threads) } 1 .. $runs } @threads;
figure('G21', "threads @threads, $runs runs each: different results", scalar(keys %seen), 1);
{
    local $ENV{GLIBC_TUNABLES} = 'glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable,-AVX2,-FMA,-AVX512F,-AVX512VL';
    $seen{ here(2) } = 1;
}
figure('G21', 'and without FMA and AVX2', scalar(keys %seen), 1);

my $daemon = Vt->start(jobs => 1);
my $job = $daemon->submit("$query&format=ply", $cloud);
wait_until(sub { (json($daemon->get("/v1/jobs/$job"))->{voronoid}{metrics}{iteration} // -1) >= 2 }, 20);
$daemon->stop('KILL');
my $again = Vt->start(jobs => 1, dir => $daemon->{dir});
my $end = $again->finish($job);
my $result = $again->get("/v1/jobs/$job/results/cloud")->{content};
$seen{ sha256_hex($result) } = 1;
figure('G21', "and after kill -9, in attempt $end->{voronoid}{attempt}", scalar(keys %seen), 1);

# Other compilers and optimisations build all of it once more.
exit 0 unless $option{long};
chdir "$FindBin::Bin/../../..";
for my $build (['gcc -O2', 'CC=gcc', 'CXX=g++', 'flags.release=-O2 -g'], ['clang -O3', 'CC=clang', 'CXX=clang++', 'flags.release=-O3 -g']) {
    my ($name, @arguments) = @$build;
    my $tree = 'build/' . $name =~ tr/a-zA-Z0-9//cdr;
    system('make', '-s', "B=$tree", @arguments, 'all') == 0 or die "$name does not build\n";
    local $ENV{VORONOID} = "$tree/voronoid";
    $seen{ here(2) } = 1;
    figure('G21', "and built by $name", scalar(keys %seen), 1);
}
