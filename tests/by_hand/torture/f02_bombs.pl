#!/usr/bin/perl
# Findings 1 and 2: 100 bodies at once that take long to refuse, 16 of their callers gone, and beside them another client's
# good submits. Half are Draco of 173 bytes that declares 49.9 M points, with 778 KB of zeros behind it; half PLY whose
# last line is no point.
use strict;
use warnings;
use FindBin;
use Getopt::Long;
use IO::Socket::INET;
use Time::HiRes qw(time sleep);
use lib "$FindBin::Bin/../../support";
use Vt;

GetOptions('long' => \my $long, 'seed=i' => \my $seed) or exit 2;
srand($seed // 1);
my ($bombs, $gone, $good) = (100, 16, $long ? 400 : 100);
my $points = $long ? 400_000 : 100_000;

sub status_of { my ($pid, $what) = @_; return Vt::slurp("/proc/$pid/status") =~ /^$what:\s+(\d+)/m ? $1 : 0 } # KiB
sub disk_of { return (split ' ', `du -sk $_[0] 2>/dev/null`)[0] // 0 } # KiB

# A kd-tree of 1,000 points on four places, told to be 49.9 million.
sub kd_bomb {
    my $dir = File::Temp::tempdir(CLEANUP => 1);
    my @places = ('0 0 0', '1 0 0', '0 1 0', '0 0 1');
    open my $ply, '>', "$dir/in.ply" or die;
    print $ply "ply\nformat ascii 1.0\nelement vertex 1000\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        map { "$places[$_ % 4]\n" } 1 .. 1000;
    close $ply;
    my $binary = $ENV{VORONOID} // 'build/release/voronoid';
    system("$binary convert -qf $dir/in.ply -o $dir/out.drc --quantization 8 2>/dev/null") == 0 or die 'no Draco file';
    my $bytes = Vt::slurp("$dir/out.drc");
    my $count = pack 'V', 1000;
    $bytes =~ s/\Q$count\E/pack 'V', 49_900_000/ge;
    return $bytes . "\0" x 778_000;
}

my $late = "ply\nformat ascii 1.0\nelement vertex $points\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    . join('', map { join(' ', map { sprintf '%.6f', rand } 1 .. 3) . "\n" } 2 .. $points) . "0 0 nothing\n";
my @bodies = (kd_bomb(), $late);
my $daemon = Vt->start(queue => 1000);
my $cloud = sphere_ply(500);
my $submit = '/v1/resample?points=100&iterations=0&polish=0';

sub good_submit {
    my $began = time;
    my $answer = $daemon->post($submit, $cloud, Prefer => 'respond-async');
    return ($answer->{status} == 201, time - $began);
}

good_submit() for 1 .. 10;
my $rss = status_of($daemon->{pid}, 'VmRSS');
my $disk = disk_of("$daemon->{dir}/data");

# The flood comes from another address. A process sends them all and then reads the answers.
pipe my $from, my $to or die;
my $flood = fork // die;
if (!$flood) {
    my (@sockets, %seen);
    for my $i (1 .. $bombs) {
        my $body = $bodies[$i % 2];
        my $socket = IO::Socket::INET->new(PeerAddr => $daemon->{address}, LocalAddr => '127.0.0.2', Timeout => 20) or die "connect: $!";
        local $SIG{PIPE} = 'IGNORE';
        print $socket "POST $submit HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: " . length($body) . "\r\n\r\n$body";
        $socket->flush;
        if ($i <= $gone) { close $socket }
        else { push @sockets, $socket }
    }
    print $to "sent\n";
    $to->flush;
    for my $socket (@sockets) {
        my $text = '';
        while (sysread $socket, $text, 65536, length $text) { }
        $seen{ $text =~ m{\AHTTP/1\.1 (\d)} ? "$1xx" : 'none' }++;
    }
    print $to join(' ', map { "$seen{$_} $_" } sort keys %seen), "\n";
    close $to;
    POSIX::_exit(0);
}
close $to;

my (@times, $refused, $rss_most, $disk_most);
($refused, $rss_most, $disk_most) = (0, $rss, $disk);
for (1 .. $good) {
    my ($ok, $seconds) = good_submit();
    push @times, $seconds;
    $refused++ unless $ok;
    my $now = status_of($daemon->{pid}, 'VmRSS');
    $rss_most = $now if $now > $rss_most;
    if ($_ % 10 == 0) {
        $now = disk_of("$daemon->{dir}/data");
        $disk_most = $now if $now > $disk_most;
    }
    sleep 0.02;
}
my $began = time;
my ($sent, $answers) = map { chomp; $_ } <$from>;
waitpid $flood, 0;
@times = sort { $a <=> $b } @times;
my $p99 = $times[int(0.99 * $#times)] * 1e3;
my $load = (split ' ', Vt::slurp('/proc/loadavg'))[0];
my $bound = ($bombs * length($late)) >> 10; # what was sent
my $row = sub { printf "%s\t%s\t%s\t%s\t%s\n", @_[0 .. 3], $_[4] ? 'ok' : 'short' };
$row->('F2', "good submit beside $bombs bombs, $gone callers gone, p99 of $good (load $load)", sprintf('%.0f ms', $p99), '100 ms', $p99 <= 100);
$row->('F2', 'the same, slowest', sprintf('%.0f ms', $times[-1] * 1e3), '100 ms', $times[-1] <= 0.1);
$row->('F2', 'good submits refused', $refused, '0', $refused == 0);
$row->('F2', 'answers to the bombs whose callers stayed', $answers // 'none', ($bombs - $gone) . ' 4xx or busy', ($answers // '') !~ /none/);
$row->('F1', 'daemon RSS more than before', sprintf('%.1f MB', ($rss_most - $rss) / 1024), '64 MB', $rss_most - $rss <= 65536);
$row->('F1', 'disk more than before, at most', sprintf('%.0f MB', ($disk_most - $disk) / 1024), sprintf('%.0f MB sent', $bound / 1024), $disk_most - $disk <= $bound);
