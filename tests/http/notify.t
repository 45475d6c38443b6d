#!/usr/bin/perl
# What systemd hears of the daemon: that it is ready, lives, reads its settings anew, and ends.
use strict;
use warnings;
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use IO::Select;
use IO::Socket::UNIX;
use Socket qw(SOCK_DGRAM);
use Test::More;
use Vt;

my $dir = tempdir(CLEANUP => 1);
my $supervisor = IO::Socket::UNIX->new(Local => "$dir/notify", Type => SOCK_DGRAM) // die "bind: $!";
my @heard;

# Waits until it hears a message that begins so.
sub hears {
    my ($begin) = @_;
    return wait_until(
        sub {
            while (IO::Select->new($supervisor)->can_read(0)) {
                $supervisor->recv(my $message, 1024);
                push @heard, $message;
            }
            while (@heard) { return 1 if index(shift @heard, $begin) == 0 }
            return 0;
        });
}

sub config {
    my ($level) = @_;
    spew("$dir/conf", "log-level = $level\nqueue = 3\n");
}

config('info');
local $ENV{NOTIFY_SOCKET} = "$dir/notify";
local $ENV{WATCHDOG_USEC} = 200_000;
my $daemon = Vt->start(config => "$dir/conf");
ok hears('READY=1'), 'it is ready once it listens';
ok hears('WATCHDOG=1'), 'and tells that it lives';
ok hears('WATCHDOG=1'), 'again and again';

sub told { return scalar(() = $daemon->log_text =~ m{"route":"/livez"}g) }
$daemon->get('/livez');
ok wait_until(sub { told() == 1 }), 'the log tells of a request';
config('warn');
kill 'HUP', $daemon->{pid};
ok hears("RELOADING=1\nMONOTONIC_USEC="), 'on SIGHUP it reads its settings';
ok hears('READY=1'), 'and is ready again';
$daemon->get('/livez') for 1 .. 3;

config('loud');
kill 'HUP', $daemon->{pid};
ok wait_until(sub { $daemon->log_text =~ /"msg":"settings not reloaded[^\n]*conf line 1: --log-level is \\"loud\\"/ }),
    'settings that are wrong are named, and change nothing';
is told(), 1, 'before that the log tells of no request, by the level that was read in between';
is $daemon->get('/livez')->{status}, 200, 'it goes on';
kill 'TERM', $daemon->{pid};
ok hears('STOPPING=1'), 'and says that it ends';
is Vt::reap(delete $daemon->{pid}), 0, 'as it does';
done_testing();
