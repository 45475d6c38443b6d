#!/usr/bin/perl
# The wall clock jumps under a running daemon, and between two: no result expires for that, nothing ends early or hangs.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use File::Temp qw(tempdir);
use Time::HiRes qw(sleep);
use Faults;
use Vt;

my %option = options();

# A library that puts the wall clock of a process ahead by the seconds in a file.
my $dir = tempdir(CLEANUP => 1);
open my $source, '>', "$dir/shift.c" or die "shift.c: $!";
print $source <<'C';
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
static long ahead(void)
{
    char text[32] = "";
    int fd = open(getenv("CLOCK_SHIFT"), O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return 0;
    if (read(fd, text, sizeof text - 1) < 0)
        text[0] = 0;
    close(fd);
    return atol(text);
}
int clock_gettime(clockid_t clock, struct timespec *out)
{
    int result = (int)syscall(SYS_clock_gettime, clock, out);
    if (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE)
        out->tv_sec += ahead();
    return result;
}
time_t time(time_t *out)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (out != NULL)
        *out = now.tv_sec;
    return now.tv_sec;
}
int gettimeofday(struct timeval *restrict out, void *restrict zone)
{
    struct timespec now;
    (void)zone;
    clock_gettime(CLOCK_REALTIME, &now);
    out->tv_sec = now.tv_sec;
    out->tv_usec = now.tv_nsec / 1000;
    return 0;
}
C
close $source;
if (system("cc -shared -fPIC -o $dir/shift.so $dir/shift.c -ldl") != 0) { print STDERR "g30: no compiler here\n"; exit 1 }
$ENV{CLOCK_SHIFT} = "$dir/ahead";

sub ahead {
    open my $out, '>', "$dir/ahead.new" or die "ahead: $!";
    print $out $_[0];
    close $out;
    rename "$dir/ahead.new", "$dir/ahead" or die "ahead: $!";
}

sub start {
    local $ENV{LD_PRELOAD} = "$dir/shift.so";
    return Vt->start(@_, 'result-ttl' => 86400);
}

my $hour = 3600;
my @jumps = (25 * $hour, -25 * $hour, $hour, -$hour, 2177452800 - time); # the last: to 2039
@jumps = @jumps[0, 4] unless $option{long};
my $cloud = sphere_ply(500);
for my $jump (@jumps) {
    my $name = sprintf '%+.0f h', $jump / $hour;
    ahead(0);
    my $daemon = start();
    my @done = map { $daemon->submit('points=50&iterations=2', $cloud) } 1 .. 3;
    $daemon->finish($_) for @done;
    my $runs = $daemon->submit('points=400&iterations=10000&polish=0', $cloud);
    wait_until(sub { $daemon->status($runs) eq 'running' }, 20);
    ahead($jump);
    wait_until(sub { $daemon->log_text =~ /the clock jumped/ }, 3);
    my $gone = grep { $daemon->get("/v1/jobs/$_/results/cloud")->{status} != 200 } @done;
    figure('G30', "results gone of 3 after a jump of $name", $gone, 0);
    figure('G30', 'the job that runs meanwhile', $daemon->status($runs), 'running');
    my $new = $daemon->post('/v1/resample?points=50&iterations=1', $cloud);
    figure('G30', 'a request after it', $new->{status}, 200);
    $daemon->request('DELETE', "/v1/jobs/$runs");
    figure('G30', 'exit status after it', $daemon->stop, 0);
    my $again = start(dir => $daemon->{dir});
    sleep 0.3;
    $gone = grep { $again->get("/v1/jobs/$_/results/cloud")->{status} != 200 } @done;
    figure('G30', 'results gone after a start with that clock', $gone, 0);
    $again->stop;
    ahead(0);
    my $right = start(dir => $daemon->{dir});
    sleep 0.3;
    $gone = grep { $right->get("/v1/jobs/$_/results/cloud")->{status} != 200 } @done;
    figure('G30', 'and after one with the clock put right', $gone, 0);
    $right->stop;
}
