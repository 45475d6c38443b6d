#!/usr/bin/perl
# A daemon that keeps very many jobs of real size (a report, a trace of 30 KB) and as many bytes as it may: lists, submits with
# a quota of bytes, a bare fsync and /livez in turn; then submits and /livez beside four clients that list all jobs.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Time::HiRes qw(time);
use Sockets;
use Vt;
my ($long) = Sockets::options();
my ($jobs, $times, $dir, $cloud) = ($long ? (100_000, 200) : (2_000, 40), File::Temp::tempdir(CLEANUP => 1), sphere_ply(1000));
open my $file, '>', "$dir/keys" or die "keys: $!"; # and what is synced
print $file 'key:submit,read:' . sha256_hex('k' x 30) . ":jobs=1000,rate=10000,bytes=1T\n";
$file->flush;
my %settings = (dir => $dir, jobs => 1, 'api-keys' => "$dir/keys", map { $_ => 12_000 * $jobs } 'keep-inputs', 'results-bytes');
my $daemon;
sub start { $daemon = Vt->start(%settings); $daemon->{http}{default_headers} = { Authorization => 'Bearer ' . 'k' x 30 } }
start();
$daemon->finish($daemon->submit('points=1000', $cloud));
$daemon->stop('KILL');
open my $sql, '|-', 'sqlite3', "$dir/data/jobs.sqlite" or die "sqlite3: $!";
print $sql "PRAGMA synchronous = OFF; BEGIN; CREATE TEMP TABLE n AS WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n
    WHERE i < $jobs - 1) SELECT i FROM n; INSERT INTO event SELECT seq + i, 1, 99999, randomblob(30000) FROM job, n;";
print $sql "CREATE TEMP TABLE copy AS SELECT $_.*, i FROM $_, n; UPDATE copy SET seq = seq + i"
    . ($_ eq 'job' && ", finished = finished + i, name = 'name ' || (i % 50), id = printf('%08x', i) || substr(id, 9)")
    . "; ALTER TABLE copy DROP COLUMN i; INSERT INTO $_ SELECT * FROM copy; DROP TABLE copy;" for 'job_text', 'job_end', 'job';
print $sql "INSERT INTO small_file SELECT printf('%08x', i) || substr(name, 9), size, data FROM small_file, n; COMMIT;";
close $sql or die 'sqlite3 fails';
start();
for (my ($before, $now) = (-1, 0); $now > $before + .1; sleep 2) { ($before, $now) = ($now, Sockets::cpu_seconds($daemon)) } # it looks at all of them
sub clock { my $began = time; $_[0]->(); return 1000 * (time - $began) }
sub measure {
    my ($what, $do) = @_;
    my @does = ($do, sub { print $file ' '; $file->flush; $file->sync }, sub { $daemon->get('/livez') });
    my @took = map { [map { clock($_) } @does] } 1 .. $times;
    my ($p99, $sync, $livez) = map { my $i = $_; Sockets::percentile(0.99, map { $_->[$i] } @took) } 0 .. 2;
    Sockets::row('G16', sprintf("$what with $jobs jobs, p99 (of an fsync %.1f ms, load %s)", $sync, Sockets::load()),
        sprintf('%.1f ms', $p99), '<= 50 ms', $p99 <= 50);
    Sockets::row('G16', "/livez beside $what, p99", sprintf('%.1f ms', $livez), '<= 20 ms', $livez <= 20);
}
sub listed { $_[1] == (() = $daemon->get("/v1/jobs?limit=$_[1]$_[0]")->{content} =~ /"jobID"/g) or die 'a list lacks jobs' }
my $submit = sub { $daemon->submit('points=100&iterations=1&polish=0', $cloud) };
measure('a list by name', sub { listed('&name=name%207', 30) });
measure('the newest page', sub { listed('', 100) });
measure('a submit', $submit);
my @listing = map { Sockets::beside(sub { $daemon->get('/v1/jobs?limit=10000') while -e $dir }) } 1 .. 4;
measure('a submit beside four listers', $submit);
kill 'KILL', map { $_->{pid} } @listing;
$daemon->stop('KILL');
