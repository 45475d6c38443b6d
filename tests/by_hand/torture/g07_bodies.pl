#!/usr/bin/perl
# G7: bodies with bytes changed, cut, doubled and put in, made from the corpus of the fuzzers, through the real daemon: is
# each answered, none by a 5xx, and is the daemon as it was? 2,000 of them, 20,000 with --long, or as many as --count says.
use strict;
use warnings;
use FindBin;
use Getopt::Long;
use Time::HiRes qw(time sleep);
use lib "$FindBin::Bin/../../support";
use Vt;

GetOptions('long' => \my $long, 'seed=i' => \my $seed, 'count=i' => \my $bodies) or exit 2;
$seed //= 1;
$bodies //= $long ? 20_000 : 2_000;
my $most_seconds = $long ? $ENV{TORTURE_SECONDS} // 1e9 : 8;
my $clients = 4;
my $parts = 8;
my $storms = 0;

my @seeds = map { Vt::slurp($_) } grep { -s $_ < 20_000 } glob "$FindBin::Bin/../../fuzz/corpus/{ply,draco}/*";
die 'no seeds' unless @seeds;
my @bits = ("\n", "\0", "\xff" x 4, "\x7f\xff\xff\xff", "\xff\xff\xff\x7f", 'nan', '1e400', '-1', "\0" x 100, '99999999999', "property float x\n",
    'DRACO', "end_header\n", 'x' x 2000);

sub mutant { return Vt::mutant($seeds[rand @seeds], 300, @bits) }

my $daemon = Vt->start(queue => 1000, 'result-ttl' => 1);
my $path = '/v1/inspect';
sub status_of { my ($what) = @_; return Vt::slurp("/proc/$daemon->{pid}/status") =~ /^$what:\s+(\d+)/m ? $1 : 0 } # KiB
sub fds { return scalar(my @open = glob "/proc/$daemon->{pid}/fd/*") }

# A client counts its answers: 2xx, 4xx that are problems with a type, 503 (busy), others.
sub client {
    my ($number, $count, $until) = @_;
    my $http = HTTP::Tiny->new(timeout => 60);
    my %seen = map { $_ => 0 } qw(good refused busy bad);
    srand(($seed * 100 + $storms) * 1000 + $number);
    for (1 .. $count) {
        last if time > $until;
        my $answer = $http->post("$daemon->{url}$path", { content => mutant() });
        my $is_problem = ($answer->{headers}{'content-type'} // '') =~ m{problem\+json} && $answer->{content} =~ /"type":"[^"]+"/;
        my $kind = $answer->{status} =~ /\A2/ ? 'good' : $answer->{status} =~ /\A4/ && $is_problem ? 'refused'
            : $answer->{status} == 503 && $is_problem ? 'busy' : 'bad';
        $seen{$kind}++;
    }
    return "$seen{good} $seen{refused} $seen{busy} $seen{bad}";
}

sub storm {
    my ($count, $seconds) = @_;
    my (@pipes, @sum);
    $storms++;
    for my $number (1 .. $clients) {
        pipe my $from, my $to or die;
        my $pid = fork // die;
        if (!$pid) { print $to client($number, POSIX::ceil($count / $clients), time + $seconds), "\n"; close $to; POSIX::_exit(0) }
        close $to;
        push @pipes, [$pid, $from];
    }
    for (@pipes) {
        my @told = split ' ', readline($_->[1]) // '0 0 0 1';
        $sum[$_] += $told[$_] for 0 .. 3;
        waitpid $_->[0], 0;
    }
    return @sum;
}

# What grows on and on grows in the second half as well; what a busy daemon comes to hold is there by half way. What it has
# after each eighth goes to standard error.
my ($fds_before, $fds, $rss, @held);
storm(200, 2); # a daemon that is warm
$fds_before = fds();
my ($good, $refused, $busy, $bad) = (0) x 4;
for my $part (1 .. $parts) {
    my @told = storm($bodies / $parts, $most_seconds / $parts);
    ($good, $refused, $busy, $bad) = ($good + $told[0], $refused + $told[1], $busy + $told[2], $bad + $told[3]);
    wait_until(sub { fds() <= $fds_before + 2 }, 10);
    push @held, status_of('VmRSS');
    printf STDERR "after %d bodies: %d KiB, %d descriptors\n", $good + $refused + $busy + $bad, $held[-1], fds();
}
my $sent = $good + $refused + $busy + $bad;
my $lives = kill 0, $daemon->{pid};
my $more = fds() - $fds_before;
my $grown = 100 * ($held[-1] / $held[$parts / 2 - 1] - 1);
my $crashed = () = `grep '"msg":"codec child' $daemon->{log}`;
my $row = sub { printf "G7\t%s\t%s\t%s\t%s\n", @_[0 .. 2], $_[3] ? 'ok' : 'short' };
$row->("mutated bodies answered (seed $seed): $good taken, $refused refused, $busy busy", $sent, $bodies, $sent >= $bodies);
$row->('answers that are 5xx, or no problem with a type', $bad, '0', $bad == 0);
$row->('daemon restarts', $lives ? 0 : 1, '0', $lives);
$row->('children that crashed or were stopped', $crashed, 'told, whatever it is', 1);
$row->('descriptors more than before', $more, '2', abs($more) <= 2);
$row->('RSS beside half way', sprintf('%+.1f %%', $grown), '5 %', $grown <= 5);
