#!/usr/bin/perl
# Standard error on a pipe that nobody reads: requests, the end by SIGTERM, what of the log is there for a late reader. (Before: the
# 200th line or so stopped the daemon for good, SIGTERM included.)
use strict;
use warnings;
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../../support";
use Getopt::Long;
use POSIX ();
use Time::HiRes qw(time);
use Vt;

my ($long, $seed) = (0, 1);
GetOptions('long' => \$long, 'seed=i' => \$seed) or exit 2;
$| = 1;
my $many = $long ? 60_000 : 6_000; # lines of some 330 bytes: the pipe is made to hold about 3,300

sub row { my ($what, $figure, $wanted, $holds) = @_; print join("\t", 'F04', $what, $figure, $wanted, $holds ? 'ok' : 'short'), "\n" }

# A daemon on a pipe, and the end to read from.
sub start_on_a_pipe {
    pipe my $reader, my $writer or die "pipe: $!";
    my $dir = tempdir(CLEANUP => 1);
    my $pid = fork // die "fork: $!";
    if (!$pid) {
        open STDERR, '>&', $writer or POSIX::_exit(126);
        exec $ENV{VORONOID} // 'build/release/voronoid', 'serve', '--listen', '127.0.0.1:0', '--data', "$dir/data", '--threads', 1
            or POSIX::_exit(127);
    }
    close $writer;
    my $text = '';
    sysread $reader, $text, 4096, length $text or die 'the daemon ended' until $text =~ /"address":"([^"]+)"/;
    return ($pid, "http://$1", $reader);
}

for my $read_late (0, 1) {
    my ($pid, $url, $reader) = start_on_a_pipe();
    my $http = HTTP::Tiny->new(timeout => 5);
    my ($answered, @took) = (0);
    for my $n (1 .. $many) {
        my $began = time;
        $answered++ if $http->get("$url/livez")->{status} == 200;
        push @took, time - $began;
        last if $n - $answered > 3;
    }
    @took = sort { $a <=> $b } @took;
    row("$many requests while nobody reads the log: answered", $answered, $many, $answered == $many) unless $read_late;
    row('their time, p99', sprintf('%.1f ms', 1e3 * $took[0.99 * $#took]), '10 ms at most', $took[0.99 * $#took] <= 0.01) unless $read_late;
    my $began = time;
    kill 'TERM', $pid;
    my $log = '';
    if ($read_late) {
        while (sysread $reader, $log, 1 << 20, length $log) { }
    }
    my $status = Vt::reap($pid);
    kill 'KILL', $pid if $status eq 'still running';
    my $seconds = time - $began;
    row('SIGTERM then: exit status', $status, 0, $status eq '0') unless $read_late;
    row('and time until it has ended', sprintf('%.1f s', $seconds), '5 s at most', $seconds <= 5) unless $read_late;
    next unless $read_late;
    my @lines = split /\n/, $log;
    my ($told, $found, $bad) = (0, 0, 0);
    for my $line (@lines) {
        my $of = eval { JSON::PP::decode_json($line) } // do { $bad++; next };
        $of->{msg} eq 'log lines dropped' ? ($told += $of->{lines}) : $found++;
    }
    # The requests, and the lines "draining" and "stopped".
    row("lines that a late reader finds, and those told as lost ($told)", $found + $told, $many + 2, $found + $told == $many + 2);
    row('of its lines, none of JSON', $bad, 0, $bad == 0);
}
my $daemon = Vt->start;
$daemon->get('/' . 'a' x 7900);
$daemon->stop;
my ($line) = grep { m{/aaa} } split /\n/, $daemon->log_text;
row('bytes of the line of a path of 7,900 (before: 8,200)', length $line, '1024 at most', length $line <= 1024);
