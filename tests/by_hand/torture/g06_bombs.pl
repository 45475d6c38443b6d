#!/usr/bin/perl
# G6: bodies of a few bytes that stand for gigabytes, each alone and 100 at once: what they get, how soon, what the daemon
# and its children take.
use strict;
use warnings;
use FindBin;
use Getopt::Long;
use Time::HiRes qw(time sleep);
use lib "$FindBin::Bin/../../support";
use Vt;

GetOptions('long' => \my $long, 'seed=i' => \my $seed) or exit 2;
my $daemon = Vt->start(queue => 1000);
my $path = '/v1/resample?points=100&iterations=0&polish=0';

sub kd_head { my ($n, $minor) = @_; return "DRACO\2$minor\0\1\0\0" . pack('V', $n) . "\1\1\0\11\3\0\0" }
sub ply { my ($n, $rest) = @_; return "ply\nformat ascii 1.0\nelement vertex $n\nproperty float x\nproperty float y\nproperty float z\n" . ($rest // "end_header\n0 0 0\n") }
my @bombs = (
    ['58 B of Draco, 100 M points', kd_head(100_000_000, "\3") . "\6" . pack('VV', 1, 100_000_000) . "\0" x 30],
    ['43 B of Draco, 200 points, old kd-tree', kd_head(200, "\1") . "\1\6" . pack('VV', 200, 32) . "\xff" x 10],
    ['Draco, 2^31 - 1 points', "DRACO\2\3\0\0\0\0" . pack('V', 2**31 - 1) . "\1\1\0\11\3\0\0\1"],
    ['Draco, 10^9 points', "DRACO\2\3\0\0\0\0" . pack('V', 10**9) . "\1\1\0\11\3\0\0\1"],
    ['Draco, 64 points a byte and nothing behind', "DRACO\2\3\0\0\0\0" . pack('V', 99_000) . "\1\1\0\11\3\0\0\1\0\0"],
    ['PLY, 2^32 - 1 points', ply(2**32 - 1)],
    ['PLY, a list of 2^32 - 1', "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
        . "property list uint float l\nend_header\n" . pack('f<3V', 0, 0, 0, 2**32 - 1)],
    ['PLY, a header of 1 MB', ply(1, 'comment ' . 'x' x 1_000_000)],
);

sub status_of { my ($pid, $what) = @_; return Vt::slurp("/proc/$pid/status") =~ /^$what:\s+(\d+)/m ? $1 : 0 } # KiB
sub is_refused { my ($answer) = @_; return $answer->{status} =~ /\A4/ && ($answer->{headers}{'content-type'} // '') =~ m{problem\+json} }

$daemon->post($path, sphere_ply(200)) for 1 .. 5;
my $rss = status_of($daemon->{pid}, 'VmRSS');
my ($bad, $slowest, $which) = (0, 0, '');
for my $bomb (@bombs) {
    my $began = time;
    my $answer = $daemon->post($path, $bomb->[1]);
    my $seconds = time - $began;
    $bad++ unless is_refused($answer);
    ($slowest, $which) = ($seconds, $bomb->[0]) if $seconds > $slowest;
}

# All of them, until there are 100, from as many processes.
my @children;
for my $i (1 .. 100) {
    my $bomb = $bombs[$i % @bombs];
    my $pid = fork // die;
    if (!$pid) {
        my $began = time;
        my $answer = HTTP::Tiny->new(timeout => 60)->post("$daemon->{url}$path", { content => $bomb->[1] });
        POSIX::_exit((is_refused($answer) || $answer->{status} == 503 ? 0 : 100) + (time - $began > 1 ? 1 : 0));
    }
    push @children, $pid;
}
my ($wrong, $late) = (0, 0);
for (@children) {
    waitpid $_, 0;
    my $code = $? >> 8;
    $wrong++ if $code >= 100;
    $late++ if $code % 100;
}
my $grown = status_of($daemon->{pid}, 'VmHWM') - $rss;
# What children took is told of those that ended without a word.
my @told = grep { ($_->{msg} // '') eq 'codec child ended' } $daemon->log_lines;
my $load = (split ' ', Vt::slurp('/proc/loadavg'))[0];
my $row = sub { printf "G6\t%s\t%s\t%s\t%s\n", @_[0 .. 2], $_[3] ? 'ok' : 'short' };
$row->(scalar(@bombs) . ' bombs alone, not answered 4xx problem+json', $bad, '0', $bad == 0);
$row->("slowest of them, $which (load $load)", sprintf('%.2f s', $slowest), '1 s', $slowest <= 1);
$row->('100 at once, not answered 4xx problem+json or 503', $wrong, '0', $wrong == 0);
$row->("100 at once, later than 1 s (load $load)", $late, '0', $late == 0);
$row->('daemon RSS more than before, at the most', sprintf('%.1f MB', $grown / 1024), '20 MB', $grown <= 20 << 10);
$row->('children that ended without a word', scalar @told, '0', @told == 0);
