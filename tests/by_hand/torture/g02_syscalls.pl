#!/usr/bin/perl
# The daemon dies at each system call that the store makes in a session: a start, a job, its result, its removal, the end.
# After every one of these deaths the next start has what was acknowledged.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use File::Temp qw(tempdir);
use POSIX ();
use Time::HiRes qw(sleep time);
use Faults;
use Vt;

my %option = options();
my $step = $option{long} ? 1 : 10;
my @calls = qw(fdatasync fsync renameat pwrite64 unlinkat unlink openat ftruncate write);
my $cloud = sphere_ply(200);
my $query = 'points=40&iterations=1&polish=0';
my $binary = $ENV{VORONOID} // 'build/release/voronoid';

if (system('strace -V >/dev/null 2>&1') != 0) { print STDERR "g02: no strace here\n"; exit 1 }

# A daemon under strace, which kills it at call number $n of a thread; undef when it died before it listened.
sub traced {
    my ($dir, $call, $n) = @_;
    my $port = free_port();
    my $pid = fork // die "fork: $!";
    if (!$pid) {
        open STDERR, '>', "$dir/log";
        open STDOUT, '>', '/dev/null';
        exec 'strace', '-D', '-f', '-qqq', '-o', '/dev/null', '-e', "trace=$call", '-e',
            "inject=$call:signal=KILL:when=$n", $binary, 'serve', '--listen', "127.0.0.1:$port", '--data', "$dir/data",
            '--threads', 2, '--jobs', 1, '--disk-reserve', '1M' or POSIX::_exit(127);
    }
    my $self = bless { pid => $pid, url => "http://127.0.0.1:$port", http => HTTP::Tiny->new(timeout => 20) }, 'Vt';
    my $listens = wait_until(sub { waitpid($pid, POSIX::WNOHANG()) > 0 ? -1 : Vt::slurp("$dir/log") =~ /"listening"/ }, 20);
    return $self if ($listens // -1) != -1;
    delete $self->{pid};
    return undef;
}

# The session; what was acknowledged: id => 'there' or 'gone' ('asked' in between).
sub session {
    my ($daemon) = @_;
    my %state;
    eval {
        for my $n (1, 2) {
            my $answer = $daemon->post("/v1/resample?$query", $cloud, Prefer => 'respond-async');
            die "refused\n" if $answer->{status} != 201;
            my $id = json($answer)->{jobID};
            $state{$id} = 'there';
            $daemon->finish($id);
            next if $n == 2;
            $state{$id} = 'asked';
            $state{$id} = 'gone' if $daemon->request('DELETE', "/v1/jobs/$id")->{status} == 200;
        }
    };
    return %state;
}

my $calm = Vt->start;
my $want = sha256_hex($calm->post("/v1/resample?$query", $cloud)->{content});
$calm->stop;

# What does not hold after a death; '' when all does.
sub fault {
    my ($dir, %state) = @_;
    my $daemon = eval { Vt->start(dir => $dir) } or return "no start: $@";
    my $fault = '';
    for my $id (keys %state) {
        my $answer = $daemon->get("/v1/jobs/$id");
        if ($state{$id} eq 'there') {
            my $info = $answer->{status} == 200 ? $daemon->finish($id) : { status => $answer->{status} };
            $fault .= "$id is $info->{status}; " if $info->{status} ne 'successful';
            $fault .= "$id has other bytes; "
                if $info->{status} eq 'successful' && sha256_hex($daemon->get("/v1/jobs/$id/results/cloud")->{content}) ne $want;
        } elsif ($state{$id} eq 'gone') {
            $fault .= "$id is back; " if $answer->{status} != 404;
        }
    }
    my $exit = $daemon->stop;
    return $exit eq '0' ? $fault : $fault . "exit $exit; ";
}

my ($deaths, $faults, $first, $until) = (0, 0, '', time + ($option{long} ? 7200 : 7));
my @left = map { [$_, 1 + $option{seed} % ($option{long} ? 1 : 3)] } @calls;
while (@left && time < $until) {
    my $at = shift @left;
    my ($call, $n) = @$at;
    my $dir = tempdir(CLEANUP => 1);
    my $daemon = traced($dir, $call, $n);
    my %state = $daemon ? session($daemon) : ();
    my $exit = $daemon ? $daemon->stop : 'signal 9';
    next if $exit eq '0'; # no thread made so many calls: this call is done with
    $deaths++;
    my $fault = fault($dir, %state);
    if ($fault ne '') { $faults++; $first ||= "$call $n: $fault" }
    push @left, [$call, $n + $step];
}
print STDERR "g02: $first\n" if $first ne '';
figure('G02', "deaths at a system call of @calls, every $step" . ($step > 1 ? 'th' : 'st') . ' of a thread, that the next start '
    . 'does not make good, of ' . $deaths, $faults, 0);
figure('G02', 'calls not reached in the time', scalar(@left), 0, $option{long} ? @left == 0 : 1);
