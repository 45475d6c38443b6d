#!/usr/bin/perl
# The help's backup of a daemon that runs, word for word, and what a daemon makes of it; and what a table of a newer version
# is answered.
use strict;
use warnings;
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my ($block) = map { $_->{text} } grep { $_->{text} =~ /VACUUM INTO/ } Vt::documented();
ok $block, 'the help has the block';
my $dir = tempdir(CLEANUP => 1);
my $daemon = Vt->start(data => "$dir/voronoid", jobs => 1);
my $cloud = sphere_ply(400);
my @done = map { $daemon->submit("points=$_&iterations=2", $cloud) } 50, 60, 70;
$daemon->finish($_) for @done;
my %bytes = map { $_ => $daemon->get("/v1/jobs/$_/results/cloud")->{content} } @done;
my $runs = $daemon->submit('points=300&iterations=10000&polish=0', $cloud);
my $waits = $daemon->submit('points=80&iterations=2', $cloud);
wait_until(sub { $daemon->status($runs) eq 'running' });

{
    spew("$dir/block.sh", $block);
    is system("cd $dir && XDG_STATE_HOME=$dir bash -e block.sh") >> 8, 0, 'the block runs';
}
$daemon->request('DELETE', "/v1/jobs/$_") for $runs, $waits, @done; # the backup is no part of this life
ok !-e "$dir/voronoid/backup", 'it leaves nothing in the folder of the daemon';
is $daemon->stop, 0, 'which does not mind';

is system("tar -xzf $dir/running.tar.gz -C $dir") >> 8, 0, 'the backup unpacks';
my $restored = Vt->start(data => "$dir/backup", jobs => 1);
is $restored->get("/v1/jobs/$_/results/cloud")->{content}, $bytes{$_}, 'a result is there, byte for byte' for @done;
ok wait_until(sub { $restored->status($runs) eq 'running' }), 'the job that ran is run';
$restored->request('DELETE', "/v1/jobs/$runs");
is $restored->finish($waits)->{status}, 'successful', 'and the one that waited after it';
unlike $restored->log_text, qr/LOST|damaged|"level":"error"/, 'nothing is missing';
is $restored->stop, 0, 'and it ends as any other';

is system("sqlite3 $dir/backup/jobs.sqlite 'PRAGMA user_version=99'") >> 8, 0, 'a table of a newer version';
my $before = Vt::slurp("$dir/backup/jobs.sqlite");
my ($exit, $said) = Vt::run('--listen', '127.0.0.1:0', '--data', "$dir/backup");
is $exit, 1, 'ends a start with 1';
like $said, qr/\Avoronoid: the job database has schema 99, but this version reads only \d+: start the version that wrote the database, [^\n]+\n\z/, 'and a line that says what to do';
ok $before eq Vt::slurp("$dir/backup/jobs.sqlite"), 'and is left as it is';
done_testing;
