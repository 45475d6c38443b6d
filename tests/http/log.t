#!/usr/bin/perl
# The log: whoever reads it late or never stops nothing, and whatever strangers send stays inside its line.
use strict;
use warnings;
use File::Temp qw(tempdir);
use Fcntl ();
use FindBin;
use lib "$FindBin::Bin/../support";
use POSIX ();
use Test::More;
use Time::HiRes qw(time sleep);
use Vt;

# A daemon whose standard error is a pipe of one page; it and the end to read from.
sub start_on_a_pipe {
    pipe my $reader, my $writer or die "pipe: $!";
    fcntl $writer, 1031, 4096 or die "F_SETPIPE_SZ: $!";
    my $dir = tempdir(CLEANUP => 1);
    open my $keep, '>&', \*STDERR or die "dup: $!";
    open STDERR, '>&', $writer or die "dup: $!";
    my $pid = fork // die "fork: $!";
    if (!$pid) {
        exec $ENV{VORONOID} // 'build/release/voronoid', 'serve', '--listen', '127.0.0.1:0', '--data', "$dir/data",
            '--threads', 1
            or POSIX::_exit(127);
    }
    open STDERR, '>&', $keep or die "dup: $!";
    close $writer;
    my $text = '';
    sysread $reader, $text, 4096, length $text or die 'the daemon ended' until $text =~ /"address":"([^"]+)"/;
    my $self = bless { pid => $pid, address => $1, url => "http://$1", dir => $dir }, 'Vt';
    ($self->{port}) = $1 =~ /:(\d+)$/;
    $self->{http} = HTTP::Tiny->new(timeout => 10, max_redirect => 0);
    return ($self, $reader);
}

# A page holds some twelve lines of requests.
my ($silent, $reader) = start_on_a_pipe();
my $answered = grep { $silent->get('/livez')->{status} == 200 } 1 .. 60;
is $answered, 60, 'a log that nobody reads stops no request';
my $began = time;
is $silent->stop, 0, 'nor the end of the daemon';
cmp_ok time - $began, '<', 20, 'which does not wait for a reader';

($silent, $reader) = start_on_a_pipe();
$silent->get('/livez') for 1 .. 60;
kill 'TERM', $silent->{pid};
my $rest = Vt::read_all($reader, 30);
is Vt::reap(delete $silent->{pid}, 30), 0, 'one that is read late is ended too';
is scalar(() = $rest =~ m{"route":"/livez"}g), 60, 'and not a line of it is lost';
like $rest, qr/"msg":"stopped","exit":0\}\n\z/, 'up to the last';

done_testing();
