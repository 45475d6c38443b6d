#!/usr/bin/perl
# usage: g03_poison.pl [--long] [--seed N]: jobs that crash, spin and leak among good ones. Needs the binary of
# tests/poison, whose processes do that.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support";
BEGIN { $ENV{VORONOID} = 'build/release/tests/poison/voronoid' }
use Getopt::Long;
use IO::Socket::INET;
use JSON::PP;
use List::Util qw(max shuffle sum0);
use Time::HiRes qw(time sleep);
use Vt;

my ($long, $seed) = (0, 1);
GetOptions('long' => \$long, 'seed=i' => \$seed) or die "usage: g03_poison.pl [--long] [--seed N]\n";
-x $ENV{VORONOID} or die "$ENV{VORONOID}: no such binary; make $ENV{VORONOID}\n";
srand $seed;

my ($rounds, $good) = $long ? (10, 100) : (1, 20);
my $job_seconds = 2;
my $cloud = sphere_ply(150);
my $daemon = Vt->start(jobs => 4, 'job-memory' => 16 << 20, 'job-seconds' => $job_seconds, queue => 1000);

sub row {
    my ($what, $figure, $wanted, $is_ok) = @_;
    print join("\t", 'G3', $what, $figure, $wanted, $is_ok ? 'ok' : 'short'), "\n";
}

# One request on a connection of its own: the seconds that its answer took, undef when none came in one.
sub probe {
    my $began = time;
    my $socket = IO::Socket::INET->new(PeerAddr => $daemon->{address}, Timeout => 1) or return undef;
    print $socket "GET /livez HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    return undef unless IO::Select->new($socket)->can_read(1);
    my $line = <$socket> // '';
    return $line =~ / 200 / && time - $began <= 1 ? time - $began : undef;
}

# Asks ten times a second until it is told to end; a pipe with what it found.
sub start_probes {
    pipe my $out, my $in;
    my $pid = fork // die "fork: $!";
    if ($pid) { close $in; return ($pid, $out) }
    my ($ends, @took, $missed) = (0);
    local $SIG{TERM} = sub { $ends = 1 };
    for (my $next = time; !$ends; $next += 0.1) {
        my $pause = $next - time;
        sleep $pause if $pause > 0;
        my $took = probe();
        defined $took ? push @took, $took : $missed++;
    }
    syswrite $in, join ' ', $missed // 0, scalar(@took), max(0, @took);
    POSIX::_exit(0);
}

sub submit {
    my ($path) = @_;
    my $answer = $daemon->post($path, $cloud, Prefer => 'respond-async');
    die "$path: $answer->{status} $answer->{content}" unless $answer->{status} == 201;
    return json($answer)->{jobID};
}

my ($prober, $probes) = start_probes();
my ($done, $all, @attempts, @unfailed) = (0, 0);
for (1 .. $rounds) {
    my @paths = shuffle((map { $_ % 2 ? '/v1/denoise?polish=5' : '/v1/resample?points=100&polish=5' } 1 .. $good),
        map {"/v1/$_"} qw(fault abort spin leak));
    my %job = map { submit($_) => $_ } @paths;
    for my $id (keys %job) {
        my $info = $daemon->finish($id);
        if ($job{$id} !~ /polish/) {
            push @attempts, $info->{voronoid}{attempt} if $info->{message} =~ /^crashed: the worker process crashed 2 times/;
            push @unfailed, $job{$id} if $info->{status} ne 'failed';
        } else {
            $all++;
            $done += $info->{status} eq 'successful';
        }
    }
}

# One that never ends, and one after it.
my $spin = submit('/v1/spin');
my $began = wait_until(sub { $daemon->status($spin) eq 'running' && time }, 30);
my $told = $daemon->finish($spin);
my $late = time - $began;
my $next = $daemon->finish(submit('/v1/denoise?polish=5'))->{status};

kill 'TERM', $prober;
my ($missed, $answered, $slowest) = split ' ', scalar <$probes>;
waitpid $prober, 0;
my @started = grep { $_->{msg} eq 'listening' } $daemon->log_lines;
my $exit = $daemon->stop;

row("good jobs beside jobs that crash, spin and leak, successful", "$done of $all", "$all of $all", $done == $all);
row('such jobs that did not end as failed', scalar(@unfailed), 0, !@unfailed);
row('crashes alone until a poison is failed; in all, at most', '2; ' . max(0, @attempts), '2; 3', max(0, @attempts) <= 3 && @attempts == 3 * $rounds);
row('front: restarts, exit status', @started - 1 . ", $exit", '0, 0', @started == 1 && $exit eq '0');
row('/livez at 10 Hz meanwhile: missed', sprintf('%d of %d, slowest %.0f ms', $missed, $missed + $answered, 1000 * $slowest), 0, $missed == 0);
row("job over its $job_seconds s, which does not listen: told after", sprintf('%.2f s, %s', $late, $told->{status}), '<= ' . ($job_seconds + 1) . ' s, failed',
    $late <= $job_seconds + 1 && $told->{status} eq 'failed');
row('the next job', $next, 'successful', $next eq 'successful');
