#!/usr/bin/perl
# The same request yields the same bytes: on the command line, over HTTP, as a job, as a stream, beside other jobs,
# with 1 and 3 threads, in `make soak` with 2 and 8 too.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $binary = $ENV{VORONOID} // 'build/release/voronoid';
my $folder = tempdir(CLEANUP => 1);

# A bent sheet with an open border, far from the origin, with a colour, a scalar and noise in its spacing.
my $count = 3000;
my $cloud = "ply\nformat binary_big_endian 1.0\nelement vertex $count\nproperty double x\nproperty double y\n"
    . "property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    . "property float intensity\nend_header\n";
for my $i (0 .. $count - 1) {
    my ($u, $v) = (($i * 0.754877666) - int($i * 0.754877666), ($i * 0.569840291) - int($i * 0.569840291));
    my $z = 3 * sin(4 * $u) * cos(3 * $v);
    $cloud .= pack 'd>3C3f>', 500000 + 10 * $u * $u, 6000000 + 10 * $v, 100 + $z, 255 * $u, 255 * $v, $i % 256, $z;
}
spew("$folder/in.ply", $cloud);

my %requests = (
    'PLY' => 'points=2500&iterations=6&polish=20&format=ply&normals=fit',
    'Draco' => 'ratio=0.3&iterations=12&format=drc&seed=7',
    'accelerated' => 'points=1200&iterations=8&format=ply&anderson=4&polish=10&evenness=cover',
    'in planes' => 'points=1000&iterations=3&polish=5&format=ply&patch=plane',
    'means' => 'points=900&iterations=5&format=ply&method=kmeans',
    'upsampled, plain Lloyd' => 'points=4500&iterations=4&format=ply&anderson=0&polish=0&boundary=free',
);
my %wanted;
for my $threads ($binary =~ /tsan/ ? 3 : $ENV{VT_SOAK} ? (1, 2, 3, 8) : (1, 3)) {
    for my $name (sort keys %requests) {
        my $out = "$folder/out";
        my @options = map { my ($key, $value) = split /=/; ("--$key", $value) } split /&/, $requests{$name};
        is system($binary, 'resample', "$folder/in.ply", '-f', '-o', $out, '--quiet', '--threads', $threads, @options), 0,
            "$name: the command line with $threads threads ends well";
        my $bytes = Vt::slurp($out);
        $wanted{$name} //= $bytes;
        cmp_ok length $bytes, '>', 1000, "$name: there is a cloud";
        is sha256_hex($bytes), sha256_hex($wanted{$name}), "$name: $threads threads on the command line";
    }
    my $daemon = Vt->start(threads => $threads, jobs => 3);
    like $daemon->log_text, qr/"msg":"listening".*"threads":$threads\b/, "a daemon has $threads threads";
    my %jobs = map { $_ => $daemon->submit($requests{$_}, $cloud) } sort keys %requests;
    for my $name (sort keys %requests) {
        is $daemon->finish($jobs{$name})->{status}, 'successful', "$name: a job beside two others ends well";
        is sha256_hex($daemon->get("/v1/jobs/$jobs{$name}/results/cloud")->{content}), sha256_hex($wanted{$name}),
            "$name: a job beside two others, $threads threads";
        is sha256_hex($daemon->post("/v1/resample?$requests{$name}", $cloud)->{content}), sha256_hex($wanted{$name}),
            "$name: a synchronous call, $threads threads";
    }
    my $out = "$folder/remote.drc";
    is system($binary, 'resample', "$folder/in.ply", '-f', '-o', $out, '--quiet', '--server', $daemon->{url}, '--ratio', 0.3,
        '--iterations', 12, '--seed', 7), 0, 'the command line with a server ends well';
    is sha256_hex(Vt::slurp($out)), sha256_hex($wanted{Draco}), "the command line with a server, $threads threads";
    is $daemon->stop, 0, 'the daemon ends with 0';
}
is scalar(keys %{ { map { $_ => 1 } values %wanted } }), scalar(keys %requests), 'different requests differ';
done_testing;
