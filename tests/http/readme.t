#!/usr/bin/perl
# The session of README.md, word for word, against the real daemon on its real port.
use strict;
use warnings;
use Cwd qw(getcwd);
use File::Temp qw(tempdir);
use IO::Socket::INET;
use Test::More;

open my $in, '<', 'README.md' or die "README.md: $!";
my $readme = do { local $/; <$in> };
my ($session) = $readme =~ /## A session\n.*?```sh\n(.*?)```/s;
ok(defined $session && length $session > 200, 'README.md has a session');

my $probe = IO::Socket::INET->new(LocalAddr => '127.0.0.1', LocalPort => 8080, Listen => 1, ReuseAddr => 1);
SKIP: {
    skip 'readme session: port 8080 is taken on this machine', 8 unless $probe;
    close $probe;
    my $binary = $ENV{VORONOID} // 'build/release/voronoid';
    $binary = getcwd() . "/$binary" unless $binary =~ m{^/};
    my $dir = tempdir(CLEANUP => 1);
    mkdir "$dir/bin";
    symlink $binary, "$dir/bin/voronoid";

    open my $ply, '>', "$dir/cloud.ply" or die;
    print $ply "ply\nformat ascii 1.0\nelement vertex 8000\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    srand 5;
    for (1 .. 8000) {
        my ($z, $a) = (2 * rand() - 1, 6.283185307 * rand());
        my $r = sqrt(1 - $z * $z);
        printf $ply "%.6f %.6f %.6f\n", $r * cos $a, $r * sin $a, $z;
    }
    close $ply;

    open my $script, '>', "$dir/session.sh" or die;
    print $script "set -m\n$session\nwait\n";
    close $script;
    my $out = `cd $dir && XDG_STATE_HOME=$dir/state PATH=$dir/bin:\$PATH timeout 300 bash session.sh 2>$dir/err`;
    is($?, 0, 'the session ends well') or diag(`tail -n 20 $dir/err`);

    my $head = sub { open my $f, '<:raw', shift or return ''; read $f, my $bytes, shift; return $bytes // '' };
    is($head->("$dir/even.drc", 5), 'DRACO', 'the first call leaves a Draco cloud');
    like($head->("$dir/even.ply", 200), qr/^element vertex 2000$/m, 'the job leaves a PLY of a quarter of the points');
    like($out, qr/^event: progress$/m, 'progress is streamed');
    like($out, qr/^event: end$/m, 'the stream ends');
    like($out, qr/"stopped": "iterations"/, 'the report says why it ended');
    like($out, qr/^dismissed$/m, 'a finished job can be removed');
    like($out, qr/points is 0, want a whole number from 1 to 10000000/, 'the mistake is named');
}
done_testing();
